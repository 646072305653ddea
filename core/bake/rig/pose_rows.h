#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <utility>

#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

// A matrix with a row of 3 x vertices numbers for each pose, too large for memory, such as displacements: what is
// decomposed into components. The source of the poses must outlive it.
class PoseRows {
 public:
  explicit PoseRows(PoseSet poses) : poses_(std::move(poses)) {}
  virtual ~PoseRows() = default;

  const PoseSet& poses() const { return poses_; }
  std::size_t size() const { return poses_.size(); }
  std::size_t rows() const { return poses_.source().rest().points.size(); }  // numbers a pose: 3 x vertices
  // Poses [first, first + count): count x rows() floats, one pose after the other.
  virtual void read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const = 0;
  // The same numbers of `count` of the poses, evenly spaced; of all if there are no more.
  virtual std::unique_ptr<PoseRows> subsampled(std::size_t count) const = 0;

 private:
  PoseSet poses_;
};

// Calls visit(first pose, number of poses, their rows) for blocks of at most `block` poses, and steps the progress.
void for_blocks(const PoseRows& poses, std::size_t block, const Parallel& parallel, Progress& progress,
                const std::function<void(std::size_t, std::size_t, const float*)>& visit);

// Displacements from the rest mesh.
class Displacements final : public PoseRows {
 public:
  using PoseRows::PoseRows;
  void read(std::size_t first, std::size_t count, std::span<float> values, const Parallel&) const override {
    poses().read_displacements(first, count, values);
  }
  std::unique_ptr<PoseRows> subsampled(std::size_t count) const override {
    return std::make_unique<Displacements>(poses().subsampled(count));
  }
};

}  // namespace fb::bake
