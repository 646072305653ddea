// Reads the sections of what a character has besides vertices that move, and what is known of its errors. Input is
// untrusted: every function fails with `corrupt`, `unsupported` or `limit` and names section and byte offset.
#pragma once

#include <vector>

#include "archive/container/byte_reader.h"
#include "model/character.h"
#include "model/exact_poses.h"
#include "model/expected_errors.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::archive {

inline constexpr std::uint8_t material_double_sided_flag = 1;
inline constexpr std::uint32_t no_control = 0xffffffff;  // in place of a mirror partner

// Fills the labels of all controls.
void read_labels(ByteReader& in, RigSchema& schema);
std::vector<MeshPart> read_meshes(ByteReader& in);
std::vector<Material> read_materials(ByteReader& in);
std::vector<Image> read_images(ByteReader& in);
std::vector<Socket> read_sockets(ByteReader& in);
std::vector<std::byte> read_thumbnail(ByteReader& in);
std::vector<Joint> read_joints(ByteReader& in);
// What vertices follow, to the end of the section. `vertices`: of the surface. read_weights: of so many influences.
using ReadWeights = std::pmr::vector<float> (*)(ByteReader& in, std::uint64_t count);
Skin read_influences(ByteReader& in, std::uint32_t vertices, ReadWeights read_weights);
Skin read_skin(ByteReader& in, std::uint32_t vertices);
DrivenJoints read_driven_joints(ByteReader& in, std::uint32_t vertices);
std::vector<Channel> read_channels(ByteReader& in);
// `controls`: how many the model has.
ExpectedErrors read_expected_errors(ByteReader& in, std::size_t controls);
// `vertices`: with those that carry numbers.
std::vector<ExactPose> read_exact_poses(ByteReader& in, std::size_t controls, std::size_t vertices);

}  // namespace fb::archive
