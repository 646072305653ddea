#include "bake/rig_process/rig_workers.h"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>

#include "bake/rig/source_rules.h"
#include "base/hash.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

constexpr std::chrono::milliseconds asking_interval{100};
constexpr std::chrono::milliseconds patience_at_end{500};
constexpr double start_factor = 5;  // a start takes at most so many times what a pose may take
constexpr double slow_factor = 20;  // a block, besides one hanging pose, so many times what it took before
constexpr std::size_t most_piece = 32;

// While it lives, writing to a pipe that nobody reads fails on this thread and ends nobody.
class BrokenPipes {
 public:
  BrokenPipes() {
    sigset_t pending;
    sigpending(&pending);
    ours_ = !sigismember(&pending, SIGPIPE);
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGPIPE);
    ::pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  }
  ~BrokenPipes() {
    const timespec at_once = {};
    if (ours_) ::sigtimedwait(&signals_, nullptr, &at_once);
    ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  BrokenPipes(const BrokenPipes&) = delete;
  BrokenPipes& operator=(const BrokenPipes&) = delete;

 private:
  sigset_t signals_, before_;
  bool ours_;
};

}  // namespace

// A block, what of it waits for a child, and the first of its poses that failed.
struct RigWorkers::Work {
  const EvaluationBlock* block = nullptr;  // null: children are only started
  std::atomic<std::uint64_t>* evaluated = nullptr;
  std::deque<Piece> waiting;
  std::optional<PoseError> failed;
};

RigWorkers::RigWorkers(RigCommand command, Progress* progress)
    : command_(std::move(command)), workers_(command_.workers) {
  Work none;
  try {
    if (progress) progress->begin(Phase::sampling, "starting the rig", 1);
    start(workers_[0]);
    run(none, progress, [&] { return workers_[0].state == State::idle; });
  } catch (const Error& error) {
    // A child that is `rig-host` begins with the same name.
    if (error.status() == Status::interrupted || std::string_view(error.what()).starts_with(shown(command_.name)))
      throw;
    throw Error(error.status(), shown(command_.name) + ": " + error.what());
  }
  diagonal_ = description_.rest.diagonal();
}

RigWorkers::~RigWorkers() {
  const BrokenPipes broken_pipes;
  for (Worker& worker : workers_) {
    if (!worker.child) continue;
    if (worker.state != State::idle) {
      stop(worker);
      continue;
    }
    send(worker, bye_request());
    write_some(worker);
    worker.child->close_requests();
  }
  const auto until = Clock::now() + patience_at_end;
  for (Worker& worker : workers_)
    if (worker.child)
      worker.child->wait_for_end(std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()));
}

void RigWorkers::start(Worker& worker) {
  worker.child = std::make_unique<ChildProcess>(command_.arguments);
  worker.reader = {};
  worker.state = State::starting;
  worker.begun = Clock::now();
  worker.deadline = worker.begun + std::chrono::duration_cast<Clock::duration>(
                                       std::chrono::duration<double>(start_factor * command_.pose_seconds));
  send(worker, hello_request());
}

void RigWorkers::stop(Worker& worker) {
  worker.child.reset();
  worker.state = State::stopped;
}

void RigWorkers::send(Worker& worker, const RigMessage& message) {
  worker.sending = bytes_of(message);
  worker.sent = 0;
}

// False if the child does not read any more.
bool RigWorkers::write_some(Worker& worker) {
  while (worker.sent < worker.sending.size()) {
    const ssize_t wrote =
        ::write(worker.child->requests(), worker.sending.data() + worker.sent, worker.sending.size() - worker.sent);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) return errno == EAGAIN;
    worker.sent += static_cast<std::size_t>(wrote);
  }
  return true;
}

// False at the end of what the child writes.
bool RigWorkers::read_some(Worker& worker) {
  std::array<std::byte, 1 << 16> bytes;
  while (const std::size_t wanted = worker.reader.wanted()) {
    const ssize_t got = ::read(worker.child->answers(), bytes.data(), std::min(bytes.size(), wanted));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return errno == EAGAIN;
    if (got == 0) return false;
    worker.reader.take(std::span(bytes).first(static_cast<std::size_t>(got)));
  }
  return true;
}

void RigWorkers::evaluate(const EvaluationBlock& block, Progress* progress, std::atomic<std::uint64_t>& evaluated) {
  check_poses(block.controls, description_.schema);
  Work work{&block, &evaluated, {}, {}};
  // Several pieces for each child, so that all end at about the same time.
  const std::size_t preferred = description_.preferred_block;
  const std::size_t piece =
      preferred > 0 ? preferred : std::clamp<std::size_t>(block.count / (4 * workers_.size()), 1, most_piece);
  for (std::size_t first = 0; first < block.count; first += piece)
    work.waiting.push_back({first, std::min(piece, block.count - first)});
  const auto at_rest = [&] {
    return std::ranges::none_of(workers_, [](const Worker& worker) { return worker.state == State::working; });
  };
  try {
    run(work, progress, [&] { return at_rest() && (work.waiting.empty() || work.failed); });
  } catch (const Error& error) {
    for (Worker& worker : workers_)
      if (worker.state != State::idle) stop(worker);
    if (error.status() != Status::rig) throw;
    throw Error(Status::rig, shown(command_.name) + ": " + error.what());
  }
  if (work.failed) throw *work.failed;
}

void RigWorkers::run(Work& work, Progress* progress, const std::function<bool()>& done) {
  const BrokenPipes broken_pipes;
  for (hand_out(work); !done(); hand_out(work)) {
    if (progress) progress->ask();
    wait_for_events();
    for (Worker& worker : workers_)
      if (worker.state == State::starting || worker.state == State::working) serve(worker, work);
  }
}

// Gives waiting pieces to idle children, and starts one more where there are none.
void RigWorkers::hand_out(Work& work) {
  if (work.failed) return;
  for (Worker& worker : workers_)
    if (worker.state == State::idle && !work.waiting.empty()) give(worker, work);
  const auto starting = static_cast<std::size_t>(std::ranges::count(workers_, State::starting, &Worker::state));
  std::size_t unserved = work.waiting.size() - std::min(work.waiting.size(), starting);
  for (Worker& worker : workers_)
    if (worker.state == State::stopped && unserved > 0) {
      start(worker);
      --unserved;
    }
}

void RigWorkers::give(Worker& worker, Work& work) {
  const std::size_t width = description_.schema.control_count();
  worker.piece = work.waiting.front();
  work.waiting.pop_front();
  const Piece& piece = worker.piece;
  send(worker, evaluate_request(work.block->controls.subspan(piece.first * width, piece.count * width), piece.count));
  worker.reader.limit_data(std::uint64_t{piece.count} * answer_floats(description_) * sizeof(float));
  worker.state = State::working;
  worker.begun = Clock::now();
  worker.deadline = worker.begun + std::chrono::duration_cast<Clock::duration>(time_limit(piece.count));
  *work.evaluated += piece.count;
}

std::chrono::duration<double> RigWorkers::time_limit(std::size_t poses) const {
  const double all = static_cast<double>(poses), longest = all * command_.pose_seconds;
  if (slowest_pose_ == 0) return std::chrono::duration<double>(longest);
  return std::chrono::duration<double>(std::min(longest, command_.pose_seconds + slow_factor * all * slowest_pose_));
}

void RigWorkers::wait_for_events() {
  std::vector<pollfd> polled;
  auto until = Clock::now() + asking_interval;
  for (const Worker& worker : workers_) {
    if (worker.state != State::starting && worker.state != State::working) continue;
    polled.push_back({worker.child->answers(), POLLIN, 0});
    if (worker.sent < worker.sending.size()) polled.push_back({worker.child->requests(), POLLOUT, 0});
    until = std::min(until, worker.deadline);
  }
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count() + 1;
  ::poll(polled.data(), polled.size(), static_cast<int>(std::max<std::int64_t>(left, 0)));
}

void RigWorkers::serve(Worker& worker, Work& work) {
  const bool reads = write_some(worker), writes = read_some(worker);
  if (worker.reader.wanted() == 0) return take_message(worker, work);
  if (!reads || !writes) {
    // What ends a child closes its pipes a moment before it is gone.
    const bool gone = worker.child->wait_for_end(patience_at_end);
    return lose(worker, work, gone ? worker.child->end() : "closed its pipes");
  }
  if (Clock::now() >= worker.deadline) {
    const std::chrono::duration<double> waited = Clock::now() - worker.begun;
    lose(worker, work, format("gave no answer for %.3g s", waited.count()));
  }
}

void RigWorkers::take_message(Worker& worker, Work& work) {
  const RigMessage answer = worker.reader.release();
  if (worker.state == State::starting)
    take_hello(answer);
  else
    take_points(worker, answer, work);
  worker.state = State::idle;
}

void RigWorkers::take_hello(const RigMessage& answer) {
  const std::uint64_t hash = hash64_of<std::byte>(answer.data, hash64_of(std::span<const char>(answer.text)));
  if (hello_hash_ == 0) description_ = description_of(answer);
  if (hello_hash_ != 0 && hash != hello_hash_) {
    description_of(answer);  // which may say why it is another
    fail(Status::rig, "started again, it says that it is another rig");
  }
  hello_hash_ = hash;
}

void RigWorkers::take_points(Worker& worker, const RigMessage& answer, Work& work) {
  const Piece piece = worker.piece;
  const std::size_t size = description_.rest.points.size();
  const std::span<float> points = work.block->points.subspan(piece.first * size, piece.count * size);
  if (const auto failure = read_answer(answer, description_, piece.count, points)) {
    const std::string reason =
        format("rig \"%s\" failed: %s", description_.schema.name.c_str(), failure->reason.c_str());
    return split(work, piece, {failure->pose, reason}, Status::rig);
  }
  const std::chrono::duration<double> took = Clock::now() - worker.begun;
  slowest_pose_ = std::max(slowest_pose_, took.count() / static_cast<double>(piece.count));
  if (const auto fault = find_point_fault(points, description_.rest, diagonal_)) {
    const std::string reason = format("rig \"%s\": %s", description_.schema.name.c_str(), fault->what.c_str());
    return split(work, piece, {fault->pose, reason}, fault->status);
  }
  std::ranges::fill(work.block->answered.subspan(piece.first, piece.count), 1);
}

// What becomes of the piece of a child that crashed or hangs; a child that never spoke will not speak next time either.
void RigWorkers::lose(Worker& worker, Work& work, const std::string& how) {
  const State state = worker.state;
  stop(worker);
  if (state == State::starting) fail(Status::rig, "its process %s before it said hello", how.c_str());
  split(work, worker.piece,
        {std::nullopt, format("the process of rig \"%s\" %s", description_.schema.name.c_str(), how.c_str())},
        Status::rig);
}

// Has the poses of a piece evaluated once more, the one that failed alone; or tells it, if it was alone before.
void RigWorkers::split(Work& work, const Piece& piece, const RigFailure& failure, Status status) {
  if (piece.count == 1 && piece.again) {
    if (!work.failed || piece.first < work.failed->pose()) work.failed = PoseError(status, piece.first, failure.reason);
    return;
  }
  const auto ask = [&](std::size_t first, std::size_t count) {
    if (count > 0) work.waiting.push_front({piece.first + first, count, count == 1});
  };
  if (failure.pose) {
    ask(*failure.pose + 1, piece.count - *failure.pose - 1);
    ask(0, *failure.pose);
    ask(*failure.pose, 1);
  } else {
    ask(piece.count / 2, piece.count - piece.count / 2);
    ask(0, piece.count / 2);
  }
}

}  // namespace fb::bake
