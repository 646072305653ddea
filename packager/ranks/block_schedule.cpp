#include "ranks/block_schedule.h"

#include <algorithm>
#include <utility>

namespace fb::tool {
namespace {

// A piece is its rank's share of so much of what is left: 1/3 where all ranks are alike. With 1/2, 64 ranks whose poses
// take 50 to 150 % of a second evaluate for 92.7 % of the time in place of 94.7 % (tests/bench/bench_ranks.cpp).
constexpr std::size_t shares = 3;

}  // namespace

BlockSchedule::BlockSchedule(std::size_t poses, std::vector<Rank> ranks, std::size_t most)
    : poses_(poses), ranks_(std::move(ranks)), most_(std::max<std::size_t>(most, 1)), held_(ranks_.size()) {
  for (const Rank& rank : ranks_) capacity_ += rank.poses_at_once;
}

std::optional<BlockSchedule::Piece> BlockSchedule::take(std::size_t rank) {
  const std::size_t left = poses_ - next_, at_once = ranks_.at(rank).poses_at_once;
  std::deque<Piece>& held = held_[rank];
  if (stopped_ || left == 0 || held.size() > ranks_[rank].pieces_ahead) return std::nullopt;
  // What a rank has ahead would be missed by others at the end.
  if (!held.empty() && left <= capacity_) return std::nullopt;
  const std::size_t rounds = std::max<std::size_t>(1, left / (shares * capacity_));
  const Piece piece = {next_, std::min({left, std::max(most_, at_once), rounds * at_once})};
  next_ += piece.count;
  ++outstanding_;
  held.push_back(piece);
  return piece;
}

void BlockSchedule::finish(std::size_t rank) {
  held_.at(rank).pop_front();
  --outstanding_;
}

void BlockSchedule::fail(std::size_t rank, const Failure& failure) {
  finish(rank);
  stop();
  if (!failure_ || failure.pose < failure_->pose) failure_ = failure;
}

}  // namespace fb::tool
