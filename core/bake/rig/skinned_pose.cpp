#include "bake/rig/skinned_pose.h"

#include <vector>

namespace fb::bake {

std::vector<Frame<double>> joint_matrices(std::span<const Joint> joints, std::span<const Frame<double>> frames) {
  std::vector<Frame<double>> matrices;
  for (std::size_t j = 0; j < joints.size(); ++j)
    matrices.push_back(product(frames[j], to_double(joints[j].inverse_bind)));
  return matrices;
}

std::optional<std::size_t> remove_skin(std::span<const Joint> joints, const Skin& skin,
                                       std::span<const Frame<double>> frames, std::span<float> positions) {
  const std::vector<Frame<double>> matrices = joint_matrices(joints, frames);
  for (std::size_t v = 0; v < positions.size() / 3; ++v) {
    const std::size_t count = skin.count(v), first = v * skin.influences;
    if (count == 0) continue;
    Frame<double> blend = {};
    for (std::size_t i = first; i < first + count; ++i)
      for (std::size_t k = 0; k < 12; ++k) blend[k] += double(skin.weights[i]) * matrices[skin.joints[i]][k];
    if (blend == still_frame) continue;
    const auto back = inverse(blend);
    if (!back) return v;
    const double at[3] = {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double* row = back->data() + 4 * axis;
      positions[3 * v + axis] = static_cast<float>(row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3]);
    }
  }
  return std::nullopt;
}

}  // namespace fb::bake
