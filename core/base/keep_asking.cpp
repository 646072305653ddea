#include "base/keep_asking.h"

#include "base/background_task.h"

namespace fb {

void keep_asking(Progress& progress, const std::function<void()>& work) {
  BackgroundTask task;  // waited for whatever happens: the work uses what lives on the caller's stack
  task.begin(work);
  while (!task.ends_within(std::chrono::milliseconds(100))) progress.ask();
  task.finish();
  progress.ask();
}

}  // namespace fb
