// Writes the sections that character_reader.h reads.
#pragma once

#include <vector>

#include "archive/container/byte_writer.h"
#include "model/character.h"
#include "model/exact_poses.h"
#include "model/expected_errors.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::archive {

// Whether any control has a label.
bool has_labels(const RigSchema& schema);
ByteWriter write_labels(const RigSchema& schema);
ByteWriter write_meshes(const std::vector<MeshPart>& meshes);
ByteWriter write_materials(const std::vector<Material>& materials);
ByteWriter write_images(const std::vector<Image>& images);
ByteWriter write_sockets(const std::vector<Socket>& sockets);
ByteWriter write_joints(const std::vector<Joint>& joints);
// What vertices follow, without the weights, which it returns, vertex after vertex.
std::vector<float> write_influences(ByteWriter& out, const Skin& skin);
ByteWriter write_skin(const Skin& skin);
ByteWriter write_driven_joints(const DrivenJoints& driven);
ByteWriter write_channels(const std::vector<Channel>& channels);
ByteWriter write_expected_errors(const ExpectedErrors& expected);
ByteWriter write_exact_poses(const std::vector<ExactPose>& poses);

}  // namespace fb::archive
