#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb {

// Some numbers of each pose, too many to hold together: what is decomposed into components.
class PoseRows {
 public:
  virtual ~PoseRows() = default;
  virtual std::size_t size() const = 0;  // poses
  virtual std::size_t rows() const = 0;  // numbers a pose
  // Poses [first, first + count): count x rows() floats, one pose after the other.
  virtual void read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const = 0;
};

// Calls visit(first pose, number of poses, their rows) for blocks of at most `block` poses, and tells how many are
// done.
void for_blocks(const PoseRows& poses, std::size_t block, const Parallel& parallel, Progress& progress,
                const std::function<void(std::size_t, std::size_t, const float*)>& visit);

// Displacements from the rest mesh. The set must outlive it.
class Displacements final : public PoseRows {
 public:
  explicit Displacements(const PoseSet& poses) : poses_(&poses) {}
  std::size_t size() const override { return poses_->size(); }
  std::size_t rows() const override { return poses_->source().rest().points.size(); }
  void read(std::size_t first, std::size_t count, std::span<float> values, const Parallel&) const override {
    poses_->read_displacements(first, count, values);
  }

 private:
  const PoseSet* poses_;
};

}  // namespace fb
