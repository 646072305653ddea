#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/background_task.h"
#include "base/open_descriptor.h"

namespace fb::tool {

// What takes longer than a server may stand still: a text that is made on another thread.
struct Work {
  explicit Work(std::function<std::string()> given) : make(std::move(given)) {}

  std::function<std::string()> make;
  bool done = false;
  std::string bytes;    // what it made
  std::string failure;  // or why it could not
};

// Does pieces of work one after the other on a thread of its own. Not thread-safe: all calls are of one thread.
class WorkQueue {
 public:
  WorkQueue();

  // Not to be looked at before turn() has called it done. One that waits already does not wait twice.
  void add(const std::shared_ptr<Work>& work);
  // Readable once a piece ends.
  int wake_descriptor() const { return wake_.get(); }
  // Begins the next piece where the last one has ended. Returns that one, or null where none has ended.
  std::shared_ptr<Work> turn();
  // Drops what has not begun. Whether what has begun ends within that time.
  bool ends_within(std::chrono::milliseconds time);

 private:
  void begin();
  bool take_wake();

  OpenDescriptor wake_;
  std::deque<std::shared_ptr<Work>> waiting_;  // the first is under way
  BackgroundTask task_;
};

}  // namespace fb::tool
