// A face as joints with skin weights, four a vertex, and what is left of its motion beside them.
#pragma once

#include <facebaker/facebaker_export.h>

#include <cstddef>
#include <facebaker/facebaker_bake.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "export/character_view.h"

namespace fb::tool {

class SkinnedMesh {
 public:
  // Joints found by fb_decompose. The rest points must outlive this.
  SkinnedMesh(facebaker::Decomposition decomposition, std::span<const float> rest);

  std::size_t joint_count() const { return info_.joint_count; }
  // Joint frames of poses; joints that hardly move are exactly at rest. tolerance: a distance.
  std::vector<float> fit(std::span<const float> positions, double tolerance, const Parallel& parallel) const;
  // For one pose: what has to be added to the rest points, before they are skinned, to get its positions.
  std::vector<float> unskinned(std::span<const float> frames, std::span<const float> positions) const;
  // Points of one pose: the rest points plus `moves` (3 x vertices), skinned.
  std::vector<float> skinned(std::span<const float> frames, std::span<const float> moves) const;

  // The character with these joints in place of its own, below one named "root", which stays. It borrows from both.
  CharacterView character(const CharacterView& from) const;
  // Frames of `joints` poses with that of the root before those of each.
  std::vector<float> with_root(std::span<const float> frames) const;

 private:
  struct Blend;
  Blend blend(std::span<const float> frames, std::size_t vertex) const;

  facebaker::Decomposition decomposition_;
  fb_decomposition_info info_;
  std::span<const float> rest_;
  double reach_;  // the diagonal of the rest points
  std::vector<std::string> names_;
  std::vector<std::uint16_t> joints_;  // counted with the root
};

}  // namespace fb::tool
