// What ranks tell each other, as bytes. All ranks run the same program on machines alike.
#pragma once

#include <facebaker/facebaker_source.h>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fb::tool {

using Bytes = std::vector<std::byte>;

// Rank 0: open a source.
struct OpenRequest {
  std::vector<std::string> paths;
  std::uint32_t workers = 0;  // this and the others: see fb_source_desc
  double pose_seconds = 0;
  std::uint32_t joints = FB_JOINTS_AUTO;
  std::vector<std::string> control_joints;
  std::uint32_t skip_broken = 0;
};
Bytes bytes_of(const OpenRequest& request);
OpenRequest open_request_from(std::span<const std::byte> bytes);

// Another rank: what it has opened, or why it has not.
struct OpenAnswer {
  std::string machine, failure;  // failure: empty if there is none
  std::string identity;          // see fb_source_info
  std::uint32_t poses_at_once = 1;
};
Bytes bytes_of(const OpenAnswer& answer);
OpenAnswer open_answer_from(std::span<const std::byte> bytes);

// Floats of a pose.
struct PoseSizes {
  std::size_t controls = 0, positions = 0, numbers = 0;
};
PoseSizes sizes_of(const fb_source_info& info);

// Rank 0: evaluate these poses of a block, which has a number.
Bytes evaluate_request(std::uint64_t number, const fb_pose_block& block, const PoseSizes& sizes, std::size_t first,
                       std::size_t count);
// Rank 0: stop evaluating the block.
Bytes stop_request(std::uint64_t number);
// The number of the block of either request.
std::uint64_t block_number(std::span<const std::byte> request);

// Another rank: an evaluated block, with the buffers that it points to.
class BlockAnswer {
 public:
  // Of an evaluate request.
  BlockAnswer(std::span<const std::byte> request, const PoseSizes& sizes);
  fb_pose_block& block() { return block_; }
  // After that; `reason`: of a failure.
  Bytes bytes(fb_status status, const std::string& reason) const;

 private:
  const PoseSizes sizes_;
  std::vector<float> controls_, positions_, numbers_;
  std::vector<std::uint8_t> answered_;
  fb_pose_block block_;
};

// What an answer says besides the poses.
struct BlockOutcome {
  fb_status status = FB_OK;
  std::uint64_t evaluated = 0, failed = 0;
  std::string reason;
};
// Puts the poses of an answer into a block, from pose `first` on. Fails with internal unless they are `count`.
BlockOutcome take_answer(std::span<const std::byte> answer, const PoseSizes& sizes, fb_pose_block& block,
                         std::size_t first, std::size_t count);

}  // namespace fb::tool
