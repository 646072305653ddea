#pragma once

#include "bake/rig/converted_source.h"

namespace fb::bake {

// Another source as if its controls drove no joints: only the positions are left of them.
class JointlessSource final : public ConvertedSource {
 public:
  // `source` must outlive this.
  explicit JointlessSource(Source& source);

  // Drops the numbers of joints, which come last.
  void convert(std::span<const float> controls, std::span<const float> from, std::size_t poses,
               std::span<float> to) const override;
};

}  // namespace fb::bake
