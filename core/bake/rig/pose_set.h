#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "bake/rig/source.h"
#include "base/parallel.h"

namespace fb::bake {

// Frames picked from the clips of a source, numbered as poses 0 to size() - 1: what is trained on, or measured.
class PoseSet {
 public:
  // All frames of the clips for which `wanted` is true and which are readable. The source must outlive the set.
  PoseSet(Source& source, const std::function<bool(const Clip&)>& wanted);

  // `count` of the poses, evenly spaced; all if there are no more.
  PoseSet subsampled(std::size_t count) const;
  // These poses of the set, in this order; fails on a number that is none of them.
  PoseSet picked(std::span<const std::uint32_t> poses) const;

  // Consecutive frames of one clip: poses first_pose.. of the set are frames frame.. of the source's clip.
  struct Range {
    std::size_t clip, frame, count, first_pose;
  };
  const std::vector<Range>& ranges() const { return ranges_; }

  Source& source() const { return *source_; }
  // For loops that read poses: one thread alone where the source allows no more.
  Parallel readers(const Parallel& parallel) const;
  std::size_t size() const { return size_; }
  std::vector<float> controls() const;  // size x controls
  // Controls of poses [first, first + count) only: count x controls floats.
  void read_controls(std::size_t first, std::size_t count, std::span<float> controls) const;
  // Points of poses [first, first + count): count x 3 x vertices floats; and their displacements from the rest mesh.
  void read_points(std::size_t first, std::size_t count, std::span<float> points) const;
  void read_displacements(std::size_t first, std::size_t count, std::span<float> displacements) const;

 private:
  explicit PoseSet(Source& source) : source_(&source) {}
  // Calls visit(clip, first frame, count, offset in the block) for the runs of consecutive frames of a block.
  void for_runs(std::size_t first, std::size_t count,
                const std::function<void(std::size_t, std::size_t, std::size_t, std::size_t)>& visit) const;

  Source* source_;
  std::vector<Range> ranges_;
  std::size_t size_ = 0;
};

}  // namespace fb::bake
