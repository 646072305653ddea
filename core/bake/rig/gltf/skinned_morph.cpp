#include "bake/rig/gltf/skinned_morph.h"

#include <map>

#include "base/hash.h"

namespace fb::bake {

SkinnedMorph::SkinnedMorph(const GltfJoints& joints, JointControls controls)
    : controls_(std::move(controls)), skin_(joints.skin()) {
  std::map<std::size_t, std::size_t> moved_by;  // node
  for (std::size_t n = 0; n < controls_.nodes().size(); ++n) moved_by.emplace(controls_.nodes()[n].node, n);
  for (std::size_t j = 0; j < joints.joints().size(); ++j) {
    const auto moved = moved_by.find(joints.node(j));
    parents_.push_back(joints.joints()[j].parent);
    moved_.push_back(moved == moved_by.end() || joints.repeats(j) ? still : moved->second);
    locals_.push_back(joints.local(j));
    inverse_binds_.push_back(joints.inverse_bind(j));
  }
}

std::vector<std::uint32_t> SkinnedMorph::numbers() const {
  std::vector<std::uint32_t> numbers;
  for (const std::size_t moved : moved_) numbers.push_back(moved == still ? 0 : controls_.numbers(moved));
  return numbers;
}

std::vector<Eigen::Affine3d> SkinnedMorph::places(std::span<const float> values) const {
  const std::vector<Eigen::Affine3d> moved = controls_.locals(values);
  std::vector<Eigen::Affine3d> places;
  for (std::size_t j = 0; j < parents_.size(); ++j) {
    const Eigen::Affine3d& local = moved_[j] == still ? locals_[j] : moved[moved_[j]];
    places.push_back(parents_[j] == no_joint ? local : places[parents_[j]] * local);
  }
  return places;
}

void SkinnedMorph::apply(std::span<const Eigen::Affine3d> places, std::span<float> positions) const {
  if (skin_.influences == 0) return;
  std::vector<Eigen::Affine3d> matrices;
  for (std::size_t j = 0; j < parents_.size(); ++j) matrices.push_back(places[j] * inverse_binds_[j]);
  for (std::size_t v = 0; v < positions.size() / 3; ++v) {
    const std::size_t first = v * skin_.influences;
    Eigen::Matrix<double, 3, 4> blend = Eigen::Matrix<double, 3, 4>::Zero();
    std::size_t i = first;
    for (; i < first + skin_.influences && skin_.weights[i] > 0; ++i)
      blend += double(skin_.weights[i]) * matrices[skin_.joints[i]].affine();
    if (i == first) continue;
    Eigen::Map<Eigen::Vector3f> position(&positions[3 * v]);
    position = (blend * position.cast<double>().homogeneous()).cast<float>();
  }
}

std::uint64_t SkinnedMorph::hash(std::uint64_t seed) const {
  std::uint64_t hash = hash64_of<std::uint16_t>(skin_.joints, hash64_of<float>(skin_.weights, seed));
  hash = hash64_of<std::uint32_t>(parents_, hash);
  for (std::size_t j = 0; j < parents_.size(); ++j)
    for (const Eigen::Affine3d* map : {&locals_[j], &inverse_binds_[j]})
      hash = hash64_of<double>(std::span<const double>(map->data(), 16), hash);
  for (const Control& control : controls_.controls()) hash = hash64_of<char>(control.name, hash);
  return hash;
}

}  // namespace fb::bake
