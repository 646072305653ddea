#include "bake/rig/gltf/joint_noise.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

#include "bake/rig/gltf/animation_target.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double unit_roundoff = 0x1p-24;

// Where the vertices are, at rest in the scene, that follow each joint or one below it.
std::vector<Eigen::AlignedBox3d> boxes_of(const GltfScene& scene, const GltfJoints& joints,
                                          std::span<const float> points) {
  std::vector<Eigen::AlignedBox3d> boxes(joints.joints().size());
  std::vector<Eigen::Affine3d> matrices;
  for (std::size_t j = 0; j < boxes.size(); ++j)
    matrices.push_back(scene.world(joints.node(j)) * joints.inverse_bind(j));
  const Skin& skin = joints.skin();
  for (std::size_t i = 0; i < skin.joints.size(); ++i) {
    if (!(skin.weights[i] > 0)) continue;
    const Eigen::Vector3d point = Eigen::Map<const Eigen::Vector3f>(&points[3 * (i / skin.influences)]).cast<double>();
    boxes[skin.joints[i]].extend(matrices[skin.joints[i]] * point);
  }
  for (std::size_t j = boxes.size(); j-- > 0;)
    if (const std::uint32_t parent = joints.joints()[j].parent; parent != no_joint) boxes[parent].extend(boxes[j]);
  return boxes;
}

// From a point to the furthest corner of a box.
double furthest(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& from) {
  if (box.isEmpty()) return 0;
  return (box.min() - from).cwiseAbs().cwiseMax((box.max() - from).cwiseAbs()).norm();
}

// The steps of normalised integers; 0 of other numbers.
double integer_step(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return 1.0 / 127;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1.0 / 255;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return 1.0 / 32767;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 1.0 / 65535;
    default:
      return 0;
  }
}

}  // namespace

void measure_nodes(std::vector<MovedNode>& nodes, const GltfScene& scene, const GltfJoints& joints,
                   std::span<const float> points) {
  const std::vector<Eigen::AlignedBox3d> boxes = boxes_of(scene, joints, points);
  std::vector<Eigen::AlignedBox3d> above(boxes.size());  // of the joints above each
  std::vector<std::size_t> depths(boxes.size(), 1);
  for (std::size_t j = 0; j < boxes.size(); ++j) {
    const std::uint32_t parent = joints.joints()[j].parent;
    if (parent == no_joint) continue;
    depths[j] = depths[parent] + 1;
    above[j] = above[parent];
    above[j].extend(Eigen::Vector3d(scene.world(joints.node(parent)).translation()));
  }
  for (MovedNode& node : nodes) {
    const std::size_t joint = joints.moving_joint(node.node).value();
    const Eigen::Vector3d origin = scene.world(node.node).translation();
    const Eigen::AlignedBox3d& box = boxes[joint];
    node.depth = depths[joint];
    node.far = furthest(above[joint], origin);
    node.reach = furthest(box, origin);
    node.extent = box.isEmpty() ? 0 : std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  }
}

double rotation_step(const GltfFile& file) {
  constexpr double steps_of_median = 5.1, least = 0x1p-23, most = 1.0 / 127;
  double step = least;
  std::vector<double> misses;  // of lengths
  for (const tinygltf::Animation& animation : file.model().animations)
    for (const tinygltf::AnimationChannel& channel : animation.channels) {
      if (target_of(channel).path != "rotation" || channel.sampler < 0 ||
          static_cast<std::size_t>(channel.sampler) >= animation.samplers.size())
        continue;
      const tinygltf::AnimationSampler& sampler = animation.samplers[static_cast<std::size_t>(channel.sampler)];
      try {
        const std::vector<float> values = file.floats(sampler.output, 4, std::nullopt, "rotations");
        step = std::max(step,
                        integer_step(file.model().accessors[static_cast<std::size_t>(sampler.output)].componentType));
        const bool cubic = sampler.interpolation == "CUBICSPLINE";  // tangents are no rotations
        for (std::size_t q = cubic ? 1 : 0; 4 * q + 3 < values.size(); q += cubic ? 3 : 1) {
          const double length = Eigen::Map<const Eigen::Vector4f>(&values[4 * q]).cast<double>().norm();
          if (std::isfinite(length)) misses.push_back(std::abs(length - 1));
        }
      } catch (const Error&) {  // of an animation that is not read either
      }
    }
  if (misses.empty()) return step;
  const auto middle = misses.begin() + static_cast<std::ptrdiff_t>(misses.size() / 2);
  std::ranges::nth_element(misses, middle);
  return std::max(step, std::min(steps_of_median * *middle, most));
}

JointNoise noise_of(const MovedNode& node, double translation, double scale, double rotation_step) {
  const double product = 4 * static_cast<double>(node.depth) * unit_roundoff, seen = 2 * unit_roundoff * node.extent;
  JointNoise noise;
  noise.turn = 8 * (rotation_step / 2 + product);
  noise.scale = 2 * (unit_roundoff + product) * scale;
  noise.translation = 2 * unit_roundoff * translation;
  if (node.scale > 0) {
    noise.translation = std::max(noise.translation + 2 * product * node.far / node.scale, seen / node.scale);
  }
  if (node.reach > 0) {
    noise.turn = std::max(noise.turn, seen / node.reach);
    noise.scale = std::max(noise.scale, seen / node.reach * scale / std::sqrt(3));
  }
  return noise;
}

}  // namespace fb::bake
