#pragma once

#include <cstdint>
#include <vector>

#include "bake/rig/converted_source.h"
#include "bake/rig/rotation_vector.h"

namespace fb::bake {

// What a control adds to a vector: vectors at values of the control, ascending, its rest among them, and straight lines
// between them.
struct VectorCurve {
  std::uint32_t control = 0;
  std::vector<float> values;
  std::vector<Axis> vectors;
};
// A sum over controls.
using VectorSum = std::vector<VectorCurve>;

// What single controls do to a driven joint, one after the other.
struct JointComposition {
  std::vector<VectorSum> outer_rotations;  // from the inside out
  VectorSum pivot;
  bool empty() const { return outer_rotations.empty() && pivot.empty(); }
};

// Another live source whose driven joints turn by several rotations, and about pivots, see DrivenJoint. What its
// controls add to outer rotations and pivots is given; what those leave of a joint's rotation and translation are its
// other numbers. Where a joint turns by a product of what single controls do in an order, each number is then a sum
// over controls, which the rotation vector of the product is not.
class ComposedSource final : public ConvertedSource {
 public:
  // compositions: of each driven joint; they may be empty. `source` must outlive this.
  ComposedSource(Source& source, std::vector<JointComposition> compositions);

  std::string version() const override;
  void convert(std::span<const float> controls, std::span<const float> from, std::size_t poses,
               std::span<float> to) const override;

 private:
  void compose_joint(std::size_t joint, std::span<const float> controls, const float* from, float* to) const;

  const std::vector<JointComposition> compositions_;
  std::vector<std::size_t> from_, to_;  // by joint: its first number, in the source and here
};

}  // namespace fb::bake
