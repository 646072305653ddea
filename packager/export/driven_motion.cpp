#include "export/driven_motion.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {
namespace {

// What frames in single precision are off by: parts of transforms that move less stay.
constexpr double rounding_of_parts = 5e-7;

void round_to_floats(std::span<double> numbers) {
  for (double& number : numbers) number = double(static_cast<float>(number));
}

double largest_change(std::span<const double> a, std::span<const double> b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
  return largest;
}

// q and -q turn the same way.
double change_of_turn(const std::array<double, 4>& a, std::array<double, 4> b) {
  const double change = largest_change(a, b);
  for (double& number : b) number = -number;
  return std::min(change, largest_change(a, b));
}

}  // namespace

void DrivenMotion::Nodes::add(const NodeTransform& transform, const Frame* parent) {
  const Frame place = parent ? product(*parent, transform.frame()) : transform.frame();
  transforms.push_back(transform);
  places.push_back(place);
}

DrivenMotion::DrivenMotion(const CharacterView& character, const FrameReader& frames, std::size_t count)
    : character_(character), tracks_(character.driven_joints.size()) {
  Nodes nodes;
  for (std::size_t j = 0; j < character.driven_joints.size(); ++j) {
    const Frame place = to_frame(character.driven_joints[j].rest);
    const std::optional<Frame> back = inverse(place);
    inverse_binds_.push_back(to_frame(to_floats(back.value_or(identity_place))));
    const NodeTransform node = node_of(j, nodes, place);
    rest_.emplace_back(to_floats(node.frame()));  // as fb_joint::rest has it
    sheared_ = sheared_ || node.sheared || !back;
    nodes.add(rest_[j], parent_of(j, nodes));
  }
  moving_.resize(rest_.size());
  find_moving(frames, count);
  for_frame_blocks(frames, count, [&](std::size_t, std::size_t poses, std::span<const float> block) {
    const std::size_t width = block.size() / poses;
    for (std::size_t p = 0; p < poses; ++p) add_to_tracks(nodes_of(block.subspan(p * width, width)));
  });
}

const Frame* DrivenMotion::parent_of(std::size_t joint, const Nodes& nodes) const {
  const std::uint32_t parent = character_.driven_joints[joint].parent;
  return parent == FB_NO_JOINT ? nullptr : &nodes.places[parent];
}

// In the parent as it is written, so that rounding does not add up down a chain. A parent that has become flat has no
// inverse, and its joints rest.
NodeTransform DrivenMotion::node_of(std::size_t joint, const Nodes& nodes, const Frame& place) const {
  const Frame* parent = parent_of(joint, nodes);
  if (!parent) return NodeTransform(place);
  const std::optional<Frame> back = inverse(*parent);
  if (back) return NodeTransform(product(*back, place));
  return joint < rest_.size() ? rest_[joint] : NodeTransform(identity_place);
}

DrivenMotion::Nodes DrivenMotion::nodes_of(std::span<const float> frames) const {
  Nodes nodes;
  for (std::size_t j = 0; j < rest_.size(); ++j) {
    NodeTransform transform = node_of(j, nodes, to_frame(frames.subspan(FB_FRAME_FLOATS * j, FB_FRAME_FLOATS)));
    round_to_floats(transform.translation);
    round_to_floats(transform.rotation);
    round_to_floats(transform.scale);
    if (!moving_[j].translation) transform.translation = rest_[j].translation;
    if (!moving_[j].rotation) transform.rotation = rest_[j].rotation;
    if (!moving_[j].scale) transform.scale = rest_[j].scale;
    nodes.add(transform, parent_of(j, nodes));
  }
  return nodes;
}

void DrivenMotion::find_moving(const FrameReader& frames, std::size_t count) {
  double reach = character_.mesh.diagonal();
  for (const fb_driven_joint& joint : character_.driven_joints)
    reach = std::max(reach, std::hypot(double(joint.rest[3]), double(joint.rest[7]), double(joint.rest[11])));
  std::vector<Moving> found(rest_.size(), {false, false, false});
  for_frame_blocks(frames, count, [&](std::size_t, std::size_t poses, std::span<const float> block) {
    const std::size_t width = block.size() / poses;
    for (std::size_t p = 0; p < poses; ++p) {
      const Nodes nodes = nodes_of(block.subspan(p * width, width));
      for (std::size_t j = 0; j < found.size(); ++j) {
        const NodeTransform &now = nodes.transforms[j], &rest = rest_[j];
        sheared_ = sheared_ || now.sheared;
        if (largest_change(now.translation, rest.translation) > rounding_of_parts * reach) found[j].translation = true;
        if (change_of_turn(now.rotation, rest.rotation) > rounding_of_parts) found[j].rotation = true;
        if (largest_change(now.scale, rest.scale) > rounding_of_parts) found[j].scale = true;
      }
    }
  });
  moving_ = std::move(found);
}

void DrivenMotion::add_to_tracks(const Nodes& nodes) {
  const auto append = [](std::vector<float>& to, const std::array<double, 3>& numbers) {
    for (const double number : numbers) to.push_back(static_cast<float>(number));
  };
  for (std::size_t j = 0; j < rest_.size(); ++j) {
    const NodeTransform& transform = nodes.transforms[j];
    if (moving_[j].translation) append(tracks_[j].translations, transform.translation);
    if (moving_[j].rotation) tracks_[j].add_rotation(transform.rotation);
    if (moving_[j].scale) append(tracks_[j].scales, transform.scale);
  }
}

std::vector<float> DrivenMotion::skinned(std::span<const float> frames, std::span<const float> points) const {
  std::vector<Frame> matrices = nodes_of(frames).places;
  for (std::size_t j = 0; j < matrices.size(); ++j) matrices[j] = product(matrices[j], inverse_binds_[j]);
  std::vector<float> posed(points.begin(), points.end());
  const std::size_t influences = character_.driven_influences;
  for (std::size_t v = 0; v < points.size() / 3; ++v) {
    const std::span<const float> at = points.subspan(3 * v, 3);
    for (std::size_t row = 0; row < 3; ++row) {
      double sum = double(at[row]);
      for (std::size_t k = influences * v; k < influences * (v + 1); ++k) {
        const double* line = &matrices[character_.driven_skin_joints[k]][4 * row];
        sum += double(character_.driven_skin_weights[k]) * (line[0] * double(at[0]) + line[1] * double(at[1]) +
                                                            line[2] * double(at[2]) + line[3] - double(at[row]));
      }
      posed[3 * v + row] = static_cast<float>(sum);
    }
  }
  return posed;
}

}  // namespace fb::tool
