// Joints, or other nodes, whose motion is controls of a rig.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/rig/gltf/gltf_scene.h"
#include "bake/rig/source.h"
#include "model/rig_schema.h"

namespace fb::bake {

// A node whose motion is read.
struct MovedNode {
  std::size_t node = 0;
  std::string name;
  NodeParts rest;
  bool chosen = false;  // by its name: it is a control even where no animation moves it
  double scale = 1;     // from its parent to the scene: lengths there over those here
  // See joint_noise.h; lengths in the scene, at rest.
  std::size_t depth = 1;  // of nodes from the scene to it
  double far = 0;         // to the furthest node above it
  double reach = 0;       // to the furthest vertex that it moves
  double extent = 0;      // the largest coordinate of these
};

// What clips have of a moved node: its translation, its rotation (a quaternion: x, y, z, w), its scale.
inline constexpr std::size_t moved_columns = 10, rotation_column = 3, scale_column = 7;
std::array<float, moved_columns> rest_columns(const NodeParts& rest);

// The controls of moved nodes: their offsets from rest, all 0 at rest.
//
//   NAME.tx, .ty, .tz   added to the translation, in metres
//   NAME.rx, .ry, .rz   a rotation vector in degrees: its direction is the axis, in the node as it is at rest, its
//                       length the angle; applied after the rotation at rest. Smooth everywhere.
//   NAME.sx, .sy, .sz   added to the scale
//
// Those that no clip moves by more than noise_of are none. Ranges are those of the clips, with rest; a chosen node that
// no clip turns turns by 30 degrees either way around each axis. In a clip a rotation vector goes on beyond half a
// turn, to three quarters of a turn at most, rather than jump to the other side at once.
class JointControls {
 public:
  JointControls() = default;
  // `clips`: `before` columns of other controls a frame, then moved_columns a node, which become columns of controls.
  // `rotation_step`: see joint_noise.h.
  JointControls(std::vector<MovedNode> nodes, std::vector<Clip>& clips, std::size_t before, double rotation_step);

  // Grouped by node, with units.
  const std::vector<Control>& controls() const { return controls_; }
  const std::vector<MovedNode>& nodes() const { return nodes_; }
  // Offsets that clips move by no more than rounding, and which are no controls.
  std::size_t noise_count() const { return noise_count_; }
  // How the controls of one of nodes() move it, see DrivenJoint::numbers: along the axes that it has at rest.
  std::uint32_t numbers(std::size_t node) const;
  // Whether a control may make a node flat, or mirror it.
  bool flatten() const;
  // Where each of nodes() is in its parent. `values`: one of each control.
  std::vector<Eigen::Affine3d> locals(std::span<const float> values) const;

 private:
  static constexpr std::size_t offsets = 9;  // of a node: translation, rotation, scale
  struct Range {
    float least = 0, most = 0;
  };
  std::vector<Range> read_offsets(std::vector<Clip>& clips, std::size_t before) const;
  void add(std::size_t node, std::size_t offset, Range range);
  void choose(const std::vector<Range>& ranges, double rotation_step);
  void keep_columns(std::vector<Clip>& clips, std::size_t before) const;

  std::vector<MovedNode> nodes_;
  std::vector<Control> controls_;
  std::vector<std::size_t> offset_of_;  // of each control, among offsets of all nodes
  std::size_t noise_count_ = 0;
};

}  // namespace fb::bake
