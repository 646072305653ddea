// Which rank gets which poses.
#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "base/random.h"
#include "ranks/block_schedule.h"

using fb::tool::BlockSchedule;

namespace {

constexpr std::size_t no_limit = 1000000;

}  // namespace

TEST_CASE("every pose is handed out once, in order, in pieces that shrink, whichever rank is quick") {
  fb::Random random(3);
  BlockSchedule schedule(1000, {{1, 0}, {1, 1}, {4, 1}, {1, 1}}, no_limit);
  std::vector<std::size_t> sizes;
  std::size_t next = 0;
  for (int step = 0; !schedule.done(); ++step) {
    REQUIRE(step < 100000);
    const std::size_t rank = random.next() % 4;
    if (const auto piece = schedule.take(rank)) {
      CHECK(piece->first == next);
      next += piece->count;
      sizes.push_back(piece->count);
      CHECK((rank != 2 || piece->count % 4 == 0 || next == 1000));
    } else if (schedule.held(rank) > 0) {
      schedule.finish(rank);
    }
  }
  CHECK(next == 1000);
  CHECK(sizes.front() > 10);
  CHECK(sizes.back() <= 4);
  CHECK(std::ranges::count_if(sizes, [](std::size_t size) { return size <= 4; }) > 8);
}

TEST_CASE("a rank has one piece ahead at most, and none when others would miss it") {
  BlockSchedule schedule(100, {{1, 0}, {1, 1}}, no_limit);
  CHECK(schedule.take(0));
  CHECK_FALSE(schedule.take(0));
  CHECK(schedule.take(1));
  CHECK(schedule.take(1));
  CHECK_FALSE(schedule.take(1));
  CHECK(schedule.held(1) == 2);

  BlockSchedule few(3, {{1, 0}, {1, 1}, {1, 1}}, no_limit);
  CHECK(few.take(1)->count == 1);
  CHECK_FALSE(few.take(1));
  CHECK(few.take(2)->count == 1);
  CHECK(few.take(0)->count == 1);
  CHECK_FALSE(few.done());
}

TEST_CASE("a piece has no more poses than fit a message, and never fewer than one") {
  BlockSchedule schedule(1000, {{1, 0}}, 7);
  CHECK(schedule.take(0)->count == 7);
  BlockSchedule large(10, {{1, 0}}, 0);
  CHECK(large.take(0)->count == 1);
}

TEST_CASE("of failures, the first of the block is kept; what is in work is finished, and nothing begun") {
  BlockSchedule schedule(1000, {{1, 0}, {1, 1}}, no_limit);
  const auto mine = *schedule.take(0), theirs = *schedule.take(1), ahead = *schedule.take(1);
  schedule.fail(1, {theirs.first + 1, 11, "later"});
  CHECK_FALSE(schedule.take(1));
  CHECK_FALSE(schedule.done());
  schedule.fail(0, {mine.first, 11, "sooner"});
  CHECK(schedule.oldest(1).first == ahead.first);
  schedule.finish(1);
  CHECK(schedule.done());
  REQUIRE(schedule.failure());
  CHECK(schedule.failure()->pose == mine.first);
  CHECK(schedule.failure()->reason == "sooner");
}

TEST_CASE("a stopped block is done once nothing is in work") {
  BlockSchedule schedule(1000, {{1, 0}, {1, 1}}, no_limit);
  schedule.take(1);
  schedule.stop();
  CHECK_FALSE(schedule.take(0));
  CHECK_FALSE(schedule.done());
  schedule.finish(1);
  CHECK(schedule.done());
  CHECK_FALSE(schedule.failure());
}
