#include "archive/character_writer.h"

namespace fb::archive {

ByteWriter write_driven_joints(const DrivenJoints& driven) {
  ByteWriter out;
  out.count(driven.joints.size(), "driven joints");
  for (const DrivenJoint& joint : driven.joints) {
    out.string(joint.name, "a driven joint's name");
    out.number(joint.parent);
    out.number(static_cast<std::uint16_t>(joint.numbers));
    out.number(static_cast<std::uint8_t>(joint.outer_rotations.size()));
    out.numbers(joint.outer_rotations);
    for (const float value : joint.rest) out.number(value);
  }
  out.numbers(driven.scales);
  std::vector<std::uint16_t> whole;
  for (const float weight : write_influences(out, driven.skin))
    whole.push_back(static_cast<std::uint16_t>(weight * static_cast<float>(driven_weight_unit)));
  out.numbers(whole);
  return out;
}

}  // namespace fb::archive
