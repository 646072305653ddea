#include "archive/character_reader.h"
#include "archive/container/container_layout.h"

namespace fb::archive {
namespace {

// The corrections of one axis, one a vertex.
void read_corrections(ByteReader& in, std::size_t axis, std::size_t vertices, ExactPose& pose) {
  const auto differences = in.temporary_planes(vertices, "corrections");
  std::uint32_t value = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    value += from_zigzag(differences[v]);
    pose.values[3 * v + axis] = static_cast<std::int32_t>(value);
  }
}

}  // namespace

std::vector<ExactPose> read_exact_poses(ByteReader& in, std::size_t controls, std::size_t vertices) {
  constexpr std::size_t pose_bytes = 4 + 4 + 4;  // and controls and values
  std::vector<ExactPose> poses;
  in.budget().resize(poses, in.count(pose_bytes, "exact poses"), "exact poses");
  if (poses.empty()) in.corrupt("there are no exact poses");
  for (ExactPose& pose : poses) {
    pose.name = in.string("an exact pose's name");
    pose.controls = in.numbers<float>(controls, "an exact pose's controls");
    pose.falloff = in.number<float>("an exact pose's falloff");
    pose.step = in.number<float>("an exact pose's step");
  }
  for (ExactPose& pose : poses) {
    if (vertices > in.left() / 12) in.corrupt("corrections need more than the bytes left");
    in.budget().resize(pose.values, 3 * vertices, "corrections");
    for (std::size_t axis = 0; axis < 3; ++axis) read_corrections(in, axis, vertices, pose);
  }
  in.end();
  return poses;
}

}  // namespace fb::archive
