#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/rig/evaluation_backend.h"
#include "bake/rig_process/child_process.h"
#include "bake/rig_process/rig_messages.h"
#include "base/progress.h"

namespace fb::bake {

// How to start the child processes of a rig.
struct RigCommand {
  std::string name;                    // of the source, for messages
  std::vector<std::string> arguments;  // the program and its arguments
  std::size_t workers = 1;             // children at once, at least 1
  double pose_seconds = 60;            // a pose that takes longer hangs; a start may take five times as long
  std::uint64_t program_hash = 0;      // see Source::program_hash
};

// Child processes that evaluate the poses of one rig at once; all are driven by the calling thread. They are started
// when there is work for them, and again when they crash or hang. Not thread-safe.
class RigWorkers {
 public:
  // Starts the first child and waits for what it says about itself. Fails with rig: it ends, says nothing in time, or
  // speaks something else than the rig protocol.
  RigWorkers(RigCommand command, Progress* progress);
  // Says bye to the children, and kills those that have not ended half a second later.
  ~RigWorkers();
  RigWorkers(const RigWorkers&) = delete;
  RigWorkers& operator=(const RigWorkers&) = delete;

  const RigDescription& description() const { return description_; }
  std::size_t count() const { return command_.workers; }

  // Evaluates a block as EvaluationBackend says, asking `progress` ten times a second, and adds to `evaluated`. A piece
  // of the block whose child crashes or hangs is halved and evaluated again until the pose is known that did it. When a
  // pose has failed, pieces in work are finished, no others begun. Interrupted, it kills the children at work.
  void evaluate(const EvaluationBlock& block, Progress* progress, std::atomic<std::uint64_t>& evaluated);

 private:
  using Clock = std::chrono::steady_clock;
  enum class State { stopped, starting, idle, working };

  struct Piece {
    std::size_t first, count;  // poses of the block
    bool again = false;        // a single pose that failed before
  };

  struct Worker {
    State state = State::stopped;
    std::unique_ptr<ChildProcess> child;
    MessageReader reader;
    std::vector<std::byte> sending;
    std::size_t sent = 0;
    Piece piece{};
    Clock::time_point begun, deadline;
  };

  struct Work;  // a block in work

  void start(Worker& worker);
  void stop(Worker& worker);
  void send(Worker& worker, const RigMessage& message);
  void hand_out(Work& work);
  void give(Worker& worker, Work& work);
  void wait_for_events();
  bool write_some(Worker& worker);
  bool read_some(Worker& worker);
  void serve(Worker& worker, Work& work);
  void take_message(Worker& worker, Work& work);
  void take_hello(const RigMessage& answer);
  void take_points(Worker& worker, const RigMessage& answer, Work& work);
  void lose(Worker& worker, Work& work, const std::string& how);
  void split(Work& work, const Piece& piece, const RigFailure& failure, Status status);
  std::chrono::duration<double> time_limit(std::size_t poses) const;
  void run(Work& work, Progress* progress, const std::function<bool()>& done);

  RigCommand command_;
  RigDescription description_;
  std::uint64_t hello_hash_ = 0;  // of what the first child said
  std::vector<Worker> workers_;
  double slowest_pose_ = 0;  // seconds, of the slowest piece so far; 0: none yet
  double diagonal_ = 0;
};

}  // namespace fb::bake
