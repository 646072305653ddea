#include "bake/rig/rig_joints.h"

#include <algorithm>

#include "bake/rig/driven_pose.h"
#include "bake/rig/skinned_pose.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// By joint, whether it or one above it is moved by controls.
std::vector<std::uint8_t> driven_joints(std::span<const Joint> joints, std::span<const std::uint32_t> numbers) {
  std::vector<std::uint8_t> driven;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const std::uint32_t parent = joints[j].parent;
    driven.push_back(numbers[j] != 0 || (parent < j && driven[parent]));
  }
  return driven;
}

// The nearest of the joints above one that the host moves, or no_joint.
std::uint32_t holder_of(std::span<const Joint> joints, std::span<const std::uint8_t> driven, std::uint32_t joint) {
  std::uint32_t above = joints[joint].parent;
  while (above != no_joint && driven[above]) above = joints[above].parent;
  return above;
}

void check_holders(std::span<const Joint> joints, std::span<const std::uint8_t> driven) {
  if (std::ranges::count(driven, 0) == 0) return;
  for (std::uint32_t j = 0; j < joints.size(); ++j)
    if (driven[j] && holder_of(joints, driven, j) == no_joint)
      fail(Status::bad_data, "joint \"%s\", which controls move, hangs on none of those that they do not move",
           joints[j].name.c_str());
}

// Where driven joints are before what they hang on moves them.
std::vector<Frame<double>> held_frames(const RigJoints& joints, const Character& character,
                                       std::span<const Frame<double>> host, std::span<const Frame<double>> all) {
  std::vector<std::optional<Frame<double>>> back;
  for (const Frame<double>& matrix : joint_matrices(character.joints, host)) back.push_back(inverse(matrix));
  std::vector<Frame<double>> frames;
  for (std::size_t d = 0; d < joints.driven.size(); ++d) {
    const Frame<double>& frame = all[joints.driven[d]];
    const std::uint32_t holder = joints.holders[d];
    if (holder != no_joint && !back[holder])
      fail(Status::bad_data, "joint \"%s\" is flat", character.joints[holder].name.c_str());
    frames.push_back(holder == no_joint ? frame : product(*back[holder], frame));
    if (d < joints.straight.size()) frames[d] = product(frames[d], joints.straight[d]);
  }
  return frames;
}

std::vector<Frame<double>> picked(std::span<const Frame<double>> all, std::span<const std::uint32_t> which) {
  std::vector<Frame<double>> frames;
  for (const std::uint32_t j : which) frames.push_back(all[j]);
  return frames;
}

void remove_host_skin(const Character& character, std::span<const Frame<double>> frames, std::span<float> positions) {
  if (character.skin.influences == 0) return;
  if (const auto vertex = remove_skin(character.joints, character.skin, frames, positions))
    fail(Status::bad_data, "the blend of the joints of vertex %zu cannot be inverted", *vertex);
}

}  // namespace

Skin mapped_skin(const Skin& skin, std::span<const std::uint32_t> places) {
  Skin mapped = skin;
  for (std::size_t i = 0; i < skin.joints.size(); ++i) {
    const std::uint32_t place = places[skin.joints[i]];
    mapped.joints[i] = place == no_joint ? 0 : static_cast<std::uint16_t>(place);
    if (place == no_joint) mapped.weights[i] = 0;
  }
  tidy(mapped);
  return mapped;
}

bool all_driven(std::span<const Joint> joints, std::span<const std::uint32_t> numbers) {
  return std::ranges::count(driven_joints(joints, numbers), 0) == 0;
}

RigJoints part_joints(std::span<const std::uint32_t> numbers, Character& character, Mesh& rest) {
  const std::vector<Joint> all = std::move(character.joints);
  const Skin skin = std::move(character.skin);
  const std::vector<std::uint8_t> driven = driven_joints(all, numbers);
  check_holders(all, driven);
  RigJoints joints;
  // By joint: its place among those of its kind, and that of the host's joint that vertices follow in its place.
  std::vector<std::uint32_t> place(all.size(), no_joint), host_place(all.size(), no_joint), driven_place = host_place;
  character.joints.clear();
  for (std::uint32_t j = 0; j < all.size(); ++j) {
    std::vector<std::uint32_t>& kind = driven[j] ? joints.driven : joints.host;
    place[j] = static_cast<std::uint32_t>(kind.size());
    kind.push_back(j);
    Joint joint = all[j];
    const std::uint32_t above = driven[j] ? holder_of(all, driven, j) : joint.parent;
    const std::uint32_t above_place = above == no_joint ? no_joint : place[above];
    host_place[j] = driven[j] ? above_place : place[j];
    if (!driven[j]) {
      joint.parent = above_place;
      character.joints.push_back(std::move(joint));
      continue;
    }
    driven_place[j] = place[j];
    joints.holders.push_back(host_place[j]);
    const std::uint32_t parent = joint.parent == no_joint || !driven[joint.parent] ? no_joint : place[joint.parent];
    rest.driven.joints.push_back({joint.name, parent, numbers[j], {}});
  }
  character.skin = character.joints.empty() ? Skin{} : mapped_skin(skin, host_place);
  rest.driven.skin = mapped_skin(skin, driven_place);
  round_weights(rest.driven.skin);
  const std::vector<Frame<double>> frames = rest_frames(all), host = picked(frames, joints.host);
  with_context("at rest", [&] { remove_host_skin(character, host, rest.points); });
  const std::vector<Frame<double>> held = held_frames(joints, character, host, frames);
  for (std::size_t d = 0; d < held.size(); ++d) {
    const auto straight = straightened(held[d]), back = inverse(held[d]);
    if (!straight || !back) fail(Status::bad_data, "joint \"%s\" is flat at rest", rest.driven.joints[d].name.c_str());
    rest.driven.joints[d].rest = to_float(*straight);
    joints.straight.push_back(product(*back, to_double(rest.driven.joints[d].rest)));
  }
  if (rest.driven.skin.influences == 0) rest.driven = {};
  return joints;
}

void take_out_joints(const RigJoints& joints, const Character& character, const Mesh& rest,
                     std::span<const Frame<double>> frames, std::span<float> positions, std::span<float> numbers) {
  const std::vector<Frame<double>> host = picked(frames, joints.host);
  remove_host_skin(character, host, positions);
  if (rest.driven.empty()) return;
  find_joint_numbers(rest.driven, held_frames(joints, character, host, frames), numbers);
}

}  // namespace fb::bake
