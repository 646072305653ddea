#pragma once

#include <facebaker/facebaker_source.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ranks/block_schedule.h"
#include "ranks/rank_link.h"

namespace fb::tool {

// The ranks that evaluate the poses of one source, seen from rank 0, which evaluates too. The other ranks serve it from
// construction to destruction.
class RankSession {
 public:
  // Has the other ranks open what `desc` describes and rank 0 has opened as `source`, which outlives this. Fails with
  // rig, naming rank and machine, where one cannot, or finds another rig. Asks the progress of `desc` meanwhile.
  RankSession(RankLink& link, const fb_source_desc& desc, fb_source* source, std::uint32_t threads);
  ~RankSession();
  RankSession(const RankSession&) = delete;
  RankSession& operator=(const RankSession&) = delete;

  // Poses that blocks should have.
  std::uint32_t preferred_block() const;
  // As fb_spreader has it: the calling thread evaluates, another talks to the other ranks. Fails with internal.
  fb_status evaluate(fb_pose_block& block, std::string& reason);

 private:
  class Block;

  void take_opened(const RankMessage& message, const std::string& identity);

  RankLink& link_;
  fb_source* const source_;
  const std::uint32_t threads_;
  PoseSizes sizes_;
  std::vector<std::string> machines_;  // of each rank
  std::vector<BlockSchedule::Rank> ranks_;
  std::uint64_t number_ = 0;  // of the last block
};

}  // namespace fb::tool
