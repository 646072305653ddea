#include "support/skin.h"

namespace rigs {

Skin::Skin(const Array<float>& weights) : used_(weights.shape[1]) {
  first_.push_back(0);
  for (std::size_t vertex = 0; vertex < weights.shape[0]; ++vertex) {
    for (std::size_t joint = 0; joint < weights.shape[1]; ++joint) {
      const float weight = weights.values[vertex * weights.shape[1] + joint];
      if (weight == 0) continue;
      used_[joint] = true;
      joint_.push_back(static_cast<std::uint32_t>(joint));
      weight_.push_back(weight);
    }
    first_.push_back(static_cast<std::uint32_t>(joint_.size()));
  }
}

void Skin::apply(const JointOffset* joints, const float* points, float* positions) const {
  for (std::size_t vertex = 0; vertex + 1 < first_.size(); ++vertex) {
    float blend[12] = {};
    for (std::uint32_t i = first_[vertex]; i < first_[vertex + 1]; ++i) {
      const float* columns = joints[joint_[i]].columns;
      for (int k = 0; k < 12; ++k) blend[k] += weight_[i] * columns[k];
    }
    const float* p = points + 3 * vertex;
    for (int axis = 0; axis < 3; ++axis) {
      positions[3 * vertex + axis] =
          p[axis] + (blend[axis] * p[0] + blend[3 + axis] * p[1] + blend[6 + axis] * p[2] + blend[9 + axis]);
    }
  }
}

}  // namespace rigs
