#include "archive/character_writer.h"

namespace fb::archive {

ByteWriter write_exact_poses(const std::vector<ExactPose>& poses) {
  ByteWriter out;
  out.count(poses.size(), "exact poses");
  for (const ExactPose& pose : poses) {
    out.string(pose.name, "an exact pose's name");
    out.numbers(pose.controls);
    out.number(pose.falloff);
    out.number(pose.step);
  }
  for (const ExactPose& pose : poses)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<std::uint32_t> differences;
      std::uint32_t before = 0;
      for (std::size_t row = axis; row < pose.values.size(); row += 3) {
        const auto value = static_cast<std::uint32_t>(pose.values[row]);
        differences.push_back(to_zigzag(value - before));
        before = value;
      }
      out.planes(differences);
    }
  return out;
}

}  // namespace fb::archive
