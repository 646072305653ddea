#pragma once

#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "base/parallel.h"

namespace fb::bake {

// Poses that parts of a base are not fitted to but judged by, with their residuals: rig minus base. Uses several
// threads; one call at a time.
class HoldoutSet {
 public:
  // controls: poses x controls; residuals: poses x 3 x vertices, rig units. judged: the vertices that they are of
  // (ascending); empty: all.
  HoldoutSet(std::vector<float> controls, std::vector<float> residuals, std::vector<float> rest,
             const Parallel& parallel, std::vector<std::uint32_t> judged = {});

  // Adds a part to the base (sign 1) or removes it (-1).
  void add(const SparseBlendshapes& part, float sign);
  // By how much the sum of squared distances would grow without this part of the base.
  double increase_without(const SparseBlendshapes& part);
  // Removes parts from the base whose removal lowers the error, in their order, until none does. Returns for each
  // whether it stays.
  std::vector<bool> prune(std::span<const SparseBlendshapes* const> parts);

  struct Error {
    double rms = 0, max = 0;
  };
  Error error() const;  // rig units

 private:
  // Calls use(pose, residual, displacement) for the vertices that the part moves, several poses at once.
  template <class Use>
  void for_moved(const SparseBlendshapes& part, const Use& use);
  template <class Use>
  void for_moved_by(const SparseBlendshapes& part, const Use& use);

  std::vector<float> controls_, residuals_, rest_;
  std::vector<std::uint32_t> judged_;
  Parallel parallel_;
  std::size_t poses_, size_;
  std::vector<std::vector<float>> scratch_;  // one a worker
};

}  // namespace fb::bake
