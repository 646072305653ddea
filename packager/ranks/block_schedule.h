// Which rank evaluates which poses of a block.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace fb::tool {

// Hands out the poses of a block in their order, to each rank as it has done what it had: self-scheduling with pieces
// that shrink towards the end (Polychronopoulos and Kuck 1987, guided self-scheduling), so that ranks of any speed end
// at about the same time. Knows neither clocks nor messages; the same code runs over MPI and in a simulation. Not
// thread-safe.
class BlockSchedule {
 public:
  struct Piece {
    std::size_t first, count;  // poses of the block
  };
  struct Rank {
    std::size_t poses_at_once = 1;  // that keep all of the rank at work, such as its child processes
    std::size_t pieces_ahead = 0;   // that it may have besides the one it works on, so that it need not wait for more
  };
  struct Failure {
    std::size_t pose;  // of the block; as many as there are: not known
    std::int32_t status;
    std::string reason;
  };

  // `most`: poses of a piece, at least 1.
  BlockSchedule(std::size_t poses, std::vector<Rank> ranks, std::size_t most);

  // The next piece for a rank; nothing while it has enough, and once nothing is left or the block is stopped.
  std::optional<Piece> take(std::size_t rank);
  // The oldest piece that a rank has, which it works on.
  const Piece& oldest(std::size_t rank) const { return held_.at(rank).front(); }
  // A rank has done its oldest piece.
  void finish(std::size_t rank);
  // The same, but a pose failed. Of several, the first of the block is kept. Nothing more is handed out.
  void fail(std::size_t rank, const Failure& failure);
  // Nothing more is handed out.
  void stop() { stopped_ = true; }

  // Pieces that a rank has.
  std::size_t held(std::size_t rank) const { return held_.at(rank).size(); }
  // Whether no rank has a piece and no more are handed out.
  bool done() const { return outstanding_ == 0 && (stopped_ || next_ == poses_); }
  const std::optional<Failure>& failure() const { return failure_; }

 private:
  const std::size_t poses_;
  const std::vector<Rank> ranks_;
  const std::size_t most_;
  std::size_t capacity_ = 0;  // poses that all ranks work on at once
  std::size_t next_ = 0, outstanding_ = 0;
  bool stopped_ = false;
  std::vector<std::deque<Piece>> held_;  // of each rank, the oldest first
  std::optional<Failure> failure_;
};

}  // namespace fb::tool
