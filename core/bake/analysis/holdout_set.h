#pragma once

#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "base/parallel.h"

namespace fb::bake {

// Poses kept to judge parts of a base by, with what the base leaves over of them.
class HoldoutSet {
 public:
  // controls: poses x controls; left: poses x 3 x vertices, rig less base.
  HoldoutSet(std::vector<float> controls, std::vector<float> left, std::vector<float> rest, const Parallel& parallel);

  // The base gains (sign 1) or loses (-1) a part.
  void add(const SparseBlendshapes& part, float sign);
  // How the sum of squared distances changes if the base loses this part of it.
  double change_without(const SparseBlendshapes& part);
  // Takes parts out of the base that make it worse, in their order, until none does. Returns for each whether it is
  // kept.
  std::vector<bool> judge(std::span<const SparseBlendshapes* const> parts);

  struct Error {
    double rms = 0, max = 0;
  };
  Error error() const;  // rig units

 private:
  // Calls use(pose, left, what the part moves) for poses where it moves anything; several at once.
  template <class Use>
  void for_moved(const SparseBlendshapes& part, const Use& use);

  std::vector<float> controls_, left_, rest_;
  Parallel parallel_;
  std::size_t poses_, size_;
  std::vector<std::vector<float>> scratch_;  // of each worker
};

}  // namespace fb::bake
