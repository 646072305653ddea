#include "ranks/rank_session.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <facebaker/facebaker_bake.hpp>
#include <mutex>
#include <thread>

#include "base/status.h"
#include "ranks/serve_rank.h"

namespace fb::tool {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t largest_piece = std::size_t{64} << 20;  // bytes of positions
// Poses that each rank should find in a block. 64 ranks whose poses take 50 to 150 % of a second evaluate for 67 % of
// the time with 1, 83 % with 4 and 95 % with 16 (tests/bench/bench_ranks.cpp); what is in work when rank 0 dies is
// lost.
constexpr std::uint32_t rounds = 16;
constexpr std::chrono::milliseconds longest_pause{1}, asking_interval{100};

bool asks_to_stop(const fb_callbacks& callbacks) {
  return callbacks.progress && callbacks.progress(callbacks.user, "evaluating", 0, 0) != 0;
}

}  // namespace

// A block in work.
class RankSession::Block {
 public:
  Block(RankSession& session, fb_pose_block& block);
  fb_status evaluate(std::string& reason);

 private:
  void evaluate_here();
  void talk();
  void hand_out();
  void tell_others();
  void take(const RankMessage& message);
  void end_piece(std::size_t rank, const BlockSchedule::Piece& piece, const BlockOutcome& outcome);
  void interrupt();
  void record_exception();

  RankSession& session_;
  fb_pose_block& block_;
  std::mutex mutex_;  // of all below
  std::condition_variable piece_done_;
  BlockSchedule schedule_;
  std::uint64_t evaluated_ = 0;
  bool interrupted_ = false, told_ = false;  // told_: the other ranks know
  std::exception_ptr exception_;
};

RankSession::Block::Block(RankSession& session, fb_pose_block& block)
    : session_(session),
      block_(block),
      schedule_(block.poses, session.ranks_, largest_piece / (session.sizes_.positions * sizeof(float))) {}

fb_status RankSession::Block::evaluate(std::string& reason) {
  std::thread talking([this] { talk(); });
  evaluate_here();
  talking.join();
  if (exception_) std::rethrow_exception(exception_);
  block_.evaluated = evaluated_;
  block_.failed = block_.poses;
  if (const auto& failure = schedule_.failure()) {
    block_.failed = failure->pose;
    reason = failure->reason;
    return failure->status;
  }
  if (interrupted_) reason = "interrupted";
  return interrupted_ ? FB_ERROR_INTERRUPTED : FB_OK;
}

// Rank 0's own pieces.
void RankSession::Block::evaluate_here() try {
  const PoseSizes& sizes = session_.sizes_;
  for (;;) {
    std::optional<BlockSchedule::Piece> piece;
    {
      const std::lock_guard lock(mutex_);
      piece = schedule_.take(0);
    }
    if (!piece) return;
    fb_pose_block part = block_;
    part.threads = session_.threads_;
    part.poses = piece->count;
    part.controls += piece->first * sizes.controls;
    part.positions += piece->first * sizes.positions;
    if (part.channels) part.channels += piece->first * sizes.numbers;
    part.answered += piece->first;
    const fb_status status = fb_source_evaluate_block(session_.source_, &part);
    const std::string reason = status == FB_OK ? "" : fb_last_error();
    const std::lock_guard lock(mutex_);
    end_piece(0, *piece, {status, part.evaluated, part.failed, reason});
    piece_done_.notify_one();
  }
} catch (...) {
  record_exception();
}

// Those of the other ranks, until the block is done.
void RankSession::Block::talk() try {
  RankPause pause(longest_pause);
  auto asked = Clock::now();
  for (;;) {
    hand_out();
    while (const auto message = session_.link_.poll()) {
      take(*message);
      hand_out();
      pause.reset();
    }
    bool unwanted = false;
    if (Clock::now() - asked >= asking_interval) {
      unwanted = asks_to_stop(block_.callbacks);
      asked = Clock::now();
    }
    std::unique_lock lock(mutex_);
    if (schedule_.done() || exception_) return;
    if (unwanted) interrupt();
    if (interrupted_ && !std::exchange(told_, true)) tell_others();
    piece_done_.wait_for(lock, pause.next());
  }
} catch (...) {
  record_exception();
}

void RankSession::Block::hand_out() {
  const std::lock_guard lock(mutex_);
  for (std::size_t rank = 1; rank < session_.link_.size(); ++rank)
    while (const auto piece = schedule_.take(rank))
      session_.link_.post(rank, RankTag::evaluate,
                          evaluate_request(session_.number_, block_, session_.sizes_, piece->first, piece->count));
}

// With the lock held: that what they evaluate is not wanted any more.
void RankSession::Block::tell_others() {
  for (std::size_t rank = 1; rank < session_.link_.size(); ++rank)
    if (schedule_.held(rank) > 0) session_.link_.post(rank, RankTag::stop, stop_request(session_.number_));
}

void RankSession::Block::take(const RankMessage& message) {
  if (message.tag != RankTag::answer)
    fail(Status::internal, "rank %zu sent a message of kind %d", message.rank, static_cast<int>(message.tag));
  BlockSchedule::Piece piece;
  {
    const std::lock_guard lock(mutex_);
    piece = schedule_.oldest(message.rank);
  }
  BlockOutcome outcome = take_answer(message.bytes, session_.sizes_, block_, piece.first, piece.count);
  if (!outcome.reason.empty())
    outcome.reason += format(" (rank %zu on %s)", message.rank, session_.machines_[message.rank].c_str());
  const std::lock_guard lock(mutex_);
  end_piece(message.rank, piece, outcome);
}

// With the lock held.
void RankSession::Block::end_piece(std::size_t rank, const BlockSchedule::Piece& piece, const BlockOutcome& outcome) {
  evaluated_ += outcome.evaluated;
  if (outcome.status == FB_OK || outcome.status == FB_ERROR_INTERRUPTED) {
    schedule_.finish(rank);
    if (outcome.status != FB_OK) interrupt();
    return;
  }
  const bool known = outcome.failed < piece.count;
  schedule_.fail(rank, {known ? piece.first + outcome.failed : block_.poses, outcome.status, outcome.reason});
}

// With the lock held.
void RankSession::Block::interrupt() {
  schedule_.stop();
  interrupted_ = true;
}

void RankSession::Block::record_exception() {
  const std::lock_guard lock(mutex_);
  if (!exception_) exception_ = std::current_exception();
  schedule_.stop();
}

RankSession::RankSession(RankLink& link, const fb_source_desc& desc, fb_source* source, std::uint32_t threads)
    : link_(link), source_(source), threads_(threads), machines_(link.size()), ranks_(link.size()) {
  fb_source_info info;
  fb_source_info_init(&info);
  facebaker::check(fb_source_describe(source, &info));
  sizes_ = sizes_of(info);
  ranks_[0] = {poses_at_once(info, threads), 0};
  const Bytes request = bytes_of(OpenRequest{{desc.paths, desc.paths + desc.path_count},
                                             desc.workers,
                                             desc.pose_seconds,
                                             desc.joints,
                                             {desc.control_joints, desc.control_joints + desc.control_joint_count},
                                             desc.skip_broken});
  for (std::size_t rank = 1; rank < link.size(); ++rank) link.post(rank, RankTag::open, request);
  RankPause pause(longest_pause);
  for (std::size_t waiting = link.size() - 1; waiting > 0;) {
    if (const auto message = link.poll(RankTag::opened)) {
      take_opened(*message, info.identity);
      --waiting;
      continue;
    }
    std::this_thread::sleep_for(pause.next());
    if (asks_to_stop(desc.callbacks)) fail(Status::interrupted, "interrupted while ranks open the rig");
  }
}

void RankSession::take_opened(const RankMessage& message, const std::string& identity) {
  const OpenAnswer answer = open_answer_from(message.bytes);
  if (!answer.failure.empty())
    fail(Status::rig, "rank %zu on %s: %s", message.rank, answer.machine.c_str(), answer.failure.c_str());
  if (answer.identity != identity)
    fail(Status::rig,
         "rank %zu on %s has opened another rig than rank 0: not the same controls, rest mesh, version "
         "or program",
         message.rank, answer.machine.c_str());
  machines_[message.rank] = answer.machine;
  ranks_[message.rank] = {answer.poses_at_once, 1};
}

RankSession::~RankSession() {
  for (std::size_t rank = 1; rank < link_.size(); ++rank) link_.post(rank, RankTag::close, {});
}

std::uint32_t RankSession::preferred_block() const {
  std::size_t poses = 0;
  for (const BlockSchedule::Rank& rank : ranks_) poses += rounds * rank.poses_at_once;
  return static_cast<std::uint32_t>(std::min<std::size_t>(poses, UINT32_MAX));
}

fb_status RankSession::evaluate(fb_pose_block& block, std::string& reason) {
  ++number_;
  return Block(*this, block).evaluate(reason);
}

}  // namespace fb::tool
