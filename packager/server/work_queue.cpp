#include "server/work_queue.h"

#include <sys/eventfd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <exception>
#include <utility>

#include "base/status.h"

namespace fb::tool {

WorkQueue::WorkQueue() : wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (wake_.get() < 0) fail(Status::io, "the system gives no event descriptor: %s", std::strerror(errno));
}

void WorkQueue::add(const std::shared_ptr<Work>& work) {
  if (std::ranges::find(waiting_, work) != waiting_.end()) return;
  waiting_.push_back(work);
  if (waiting_.size() == 1) begin();
}

void WorkQueue::begin() {
  task_.begin([work = waiting_.front(), wake = wake_.get()] {
    try {
      work->bytes = work->make();
    } catch (const std::exception& error) {  // fb::Error and facebaker::Error among others
      work->failure = error.what();
      if (work->failure.empty()) work->failure = "failed without a reason";
    }
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(wake, &one, sizeof one);
  });
}

bool WorkQueue::take_wake() {
  std::uint64_t ended = 0;
  return ::read(wake_.get(), &ended, sizeof ended) == sizeof ended;
}

std::shared_ptr<Work> WorkQueue::turn() {
  if (waiting_.empty() || (!take_wake() && !task_.ends_within(std::chrono::milliseconds(0)))) return nullptr;
  task_.finish();
  take_wake();  // of this piece, where it came after it was asked for
  std::shared_ptr<Work> work = std::move(waiting_.front());
  waiting_.pop_front();
  work->done = true;
  work->make = nullptr;
  if (!waiting_.empty()) begin();
  return work;
}

bool WorkQueue::ends_within(std::chrono::milliseconds time) {
  if (waiting_.size() > 1) waiting_.resize(1);
  return waiting_.empty() || task_.ends_within(time);
}

}  // namespace fb::tool
