#include "bake/rig/gltf/joint_controls.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "bake/rig/gltf/joint_noise.h"
#include "model/driven_joints.h"

namespace fb::bake {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double half_turn = 180, whole_turn = 360;  // degrees
// Rotation vectors are no longer, in degrees: near a whole turn a small rotation changes them much.
constexpr double most_turn = 270;
constexpr float chosen_turn = 30;  // degrees
constexpr const char* offset_names[] = {".tx", ".ty", ".tz", ".rx", ".ry", ".rz", ".sx", ".sy", ".sz"};
constexpr const char* offset_units[] = {"m", "degrees", ""};

Quaterniond rotation_of(const Vector3d& degrees) {
  const Vector3d vector = degrees * (std::numbers::pi / half_turn);
  const double angle = vector.norm();
  // sin(x / 2) / x by its series where x is small.
  const double share = angle < 1e-4 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  const Vector3d xyz = share * vector;
  return {std::cos(angle / 2), xyz.x(), xyz.y(), xyz.z()};
}

// The rotation vector, in degrees, of those a rotation has that is nearest to the one before.
Vector3d rotation_vector(Quaterniond rotation, const Vector3d& before) {
  rotation.normalize();
  if (rotation.w() < 0) rotation.coeffs() *= -1;
  const double sine = rotation.vec().norm();
  const double angle = 2 * std::atan2(sine, rotation.w()) * half_turn / std::numbers::pi;
  Vector3d axis;
  if (sine > 1e-12)
    axis = rotation.vec() / sine;
  else if (before.norm() > half_turn)
    axis = before.normalized();
  else
    return Vector3d::Zero();
  double turned = angle + whole_turn * std::round((before.dot(axis) - angle) / whole_turn);
  if (std::abs(turned) > most_turn) turned = angle;
  return turned * axis;
}

}  // namespace

std::array<float, moved_columns> rest_columns(const NodeParts& rest) {
  std::array<float, moved_columns> columns{};
  Eigen::Map<Eigen::Vector3f>(columns.data()) = rest.translation.cast<float>();
  Eigen::Map<Eigen::Vector4f>(columns.data() + rotation_column) = rest.rotation.coeffs().cast<float>();
  Eigen::Map<Eigen::Vector3f>(columns.data() + scale_column) = rest.scale.cast<float>();
  return columns;
}

JointControls::JointControls(std::vector<MovedNode> nodes, std::vector<Clip>& clips, std::size_t before,
                             double rotation_step)
    : nodes_(std::move(nodes)) {
  choose(read_offsets(clips, before), rotation_step);
  keep_columns(clips, before);
}

// Turns what clips have of nodes into offsets from rest, in the first `offsets` columns of each node.
std::vector<JointControls::Range> JointControls::read_offsets(std::vector<Clip>& clips, std::size_t before) const {
  std::vector<Range> ranges(offsets * nodes_.size());
  const std::size_t width = before + moved_columns * nodes_.size();
  for (Clip& clip : clips)
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const NodeParts& rest = nodes_[n].rest;
      Vector3d turned = Vector3d::Zero();
      for (std::size_t f = 0; f < clip.frames; ++f) {
        float* at = &clip.controls[f * width + before + moved_columns * n];
        const Vector3d translation = Eigen::Map<Eigen::Vector3f>(at).cast<double>() - rest.translation;
        const Quaterniond rotation(Eigen::Map<Eigen::Vector4f>(at + rotation_column).cast<double>());
        const Vector3d scale = Eigen::Map<Eigen::Vector3f>(at + scale_column).cast<double>() - rest.scale;
        turned = rotation_vector(rest.rotation.conjugate() * rotation, turned);
        Eigen::Map<Eigen::Vector3f>(at + 0) = translation.cast<float>();
        Eigen::Map<Eigen::Vector3f>(at + 3) = turned.cast<float>();
        Eigen::Map<Eigen::Vector3f>(at + 6) = scale.cast<float>();
        for (std::size_t i = 0; i < offsets; ++i) {
          Range& range = ranges[offsets * n + i];
          range.least = std::min(range.least, at[i]);
          range.most = std::max(range.most, at[i]);
        }
      }
    }
  return ranges;
}

void JointControls::choose(const std::vector<Range>& ranges, double rotation_step) {
  const auto largest = [](const Vector3d& rest, const Range* range) {  // of a vector
    Vector3d most;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      most[axis] = std::max(std::abs(rest[axis] + range[axis].least), std::abs(rest[axis] + range[axis].most));
    return most.norm();
  };
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Range* const of_node = &ranges[offsets * n];
    const JointNoise noise = noise_of(nodes_[n], largest(nodes_[n].rest.translation, of_node),
                                      largest(nodes_[n].rest.scale, of_node + 6), rotation_step);
    const double least[] = {noise.translation, noise.turn * half_turn / std::numbers::pi, noise.scale};
    bool turns = false;
    for (std::size_t i = 0; i < offsets; ++i) {
      const Range range = of_node[i];
      const double moves = double(range.most) - range.least;
      const bool moved = moves > least[i / 3];
      turns |= moved && i / 3 == 1;
      noise_count_ += moves > 0 && !moved;
      if (!moved && i == 5 && !turns && nodes_[n].chosen) {
        for (std::size_t axis = 3; axis < 6; ++axis) add(n, axis, {-chosen_turn, chosen_turn});
      } else if (moved) {
        add(n, i, range);
      }
    }
  }
}

void JointControls::add(std::size_t node, std::size_t offset, Range range) {
  Control control{nodes_[node].name + offset_names[offset], range.least, range.most, 0, nodes_[node].name};
  control.labels.unit = offset_units[offset / 3];
  controls_.push_back(std::move(control));
  offset_of_.push_back(offsets * node + offset);
}

void JointControls::keep_columns(std::vector<Clip>& clips, std::size_t before) const {
  const std::size_t from = before + moved_columns * nodes_.size(), to = before + controls_.size();
  for (Clip& clip : clips) {
    std::vector<float> kept(clip.frames * to);
    for (std::size_t f = 0; f < clip.frames; ++f) {
      const float* frame = &clip.controls[f * from];
      std::copy(frame, frame + before, &kept[f * to]);
      for (std::size_t c = 0; c < controls_.size(); ++c)
        kept[f * to + before + c] = frame[before + moved_columns * (offset_of_[c] / offsets) + offset_of_[c] % offsets];
    }
    clip.controls = std::move(kept);
  }
}

std::uint32_t JointControls::numbers(std::size_t node) const {
  std::uint32_t numbers = 0;
  for (std::size_t c = 0; c < controls_.size(); ++c) {
    if (offset_of_[c] / offsets != node) continue;
    const std::size_t offset = offset_of_[c] % offsets, axis = offset % 3;
    if (offset < 3) {  // along the axes of the parent
      numbers |= joint_translation;
    } else {
      numbers |= offset < 6 ? 1u << axis : 1u << offset;
    }
  }
  return numbers;
}

bool JointControls::flatten() const {
  for (std::size_t c = 0; c < controls_.size(); ++c) {
    const std::size_t offset = offset_of_[c] % offsets;
    if (offset < 6) continue;
    const double rest = nodes_[offset_of_[c] / offsets].rest.scale[Eigen::Index(offset % 3)];
    if (!(rest * (rest + controls_[c].minimum) > 0 && rest * (rest + controls_[c].maximum) > 0)) return true;
  }
  return false;
}

std::vector<Eigen::Affine3d> JointControls::locals(std::span<const float> values) const {
  std::vector<double> all(offsets * nodes_.size());
  for (std::size_t c = 0; c < controls_.size(); ++c) all[offset_of_[c]] = double(values[c]);
  std::vector<Eigen::Affine3d> locals;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Eigen::Map<const Vector3d> moved(&all[offsets * n]), turned(&all[offsets * n + 3]),
        scaled(&all[offsets * n + 6]);
    const NodeParts& rest = nodes_[n].rest;
    locals.push_back(place_of({rest.translation + moved, rest.rotation * rotation_of(turned), rest.scale + scaled}));
  }
  return locals;
}

}  // namespace fb::bake
