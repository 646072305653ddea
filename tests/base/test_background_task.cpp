#include <doctest/doctest.h>

#include <stdexcept>
#include <vector>

#include "base/background_task.h"

namespace fb::test_background_task {

TEST_CASE("tasks run one after the other, and their exceptions come with the next call") {
  std::vector<int> done;  // not locked: a task begins after the one before it
  BackgroundTask task;
  task.finish();  // there is none
  for (int i = 0; i < 100; ++i) task.begin([&, i] { done.push_back(i); });
  task.finish();
  CHECK(done.size() == 100);
  task.begin([] { throw std::runtime_error("first"); });
  CHECK_THROWS_WITH(task.begin([&] { done.clear(); }), "first");
  CHECK(done.size() == 100);  // not begun
  task.begin([] { throw std::runtime_error("second"); });
  CHECK_THROWS_WITH(task.finish(), "second");
  task.finish();
}

TEST_CASE("a task is waited for before it is destroyed") {
  int value = 0;
  {
    BackgroundTask task;
    task.begin([&] { value = 1; });
  }
  CHECK(value == 1);
}

}  // namespace fb::test_background_task
