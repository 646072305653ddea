#include "archive/character_reader.h"

namespace fb::archive {
namespace {

std::pmr::vector<float> read_whole_weights(ByteReader& in, std::uint64_t count) {
  const auto whole = in.temporary_numbers<std::uint16_t>(count, "weights of vertices");
  std::pmr::vector<float> weights(whole.size(), &in.budget());
  for (std::size_t i = 0; i < whole.size(); ++i)
    weights[i] = static_cast<float>(whole[i]) / static_cast<float>(driven_weight_unit);
  return weights;
}

}  // namespace

DrivenJoints read_driven_joints(ByteReader& in, std::uint32_t vertices) {
  constexpr std::size_t joint_bytes = 4 + 4 + 2 + 1 + 12 * 4;
  DrivenJoints driven;
  in.budget().resize(driven.joints, in.count(joint_bytes, "driven joints"), "driven joints");
  if (driven.joints.empty()) in.corrupt("there are no driven joints");
  for (DrivenJoint& joint : driven.joints) {
    joint.name = in.string("a driven joint's name");
    joint.parent = in.number<std::uint32_t>("a driven joint's parent");
    joint.numbers = in.number<std::uint16_t>("which numbers a driven joint has");
    joint.outer_rotations = in.numbers<std::uint8_t>(in.number<std::uint8_t>("outer rotations of a driven joint"),
                                                     "outer rotations of a driven joint");
    for (float& value : joint.rest) value = in.number<float>("a driven joint's frame");
  }
  driven.scales = in.numbers<float>(driven.number_count(), "scales of driven joints");
  driven.skin = read_influences(in, vertices, read_whole_weights);
  return driven;
}

}  // namespace fb::archive
