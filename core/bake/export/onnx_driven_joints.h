// Driven joints (core/archive/EVALUATION.md, "Driven joints") in a graph of floats, each operation as the evaluator
// does it. A joint that is still needs no case of its own: its change is +0, and what it adds is 0.
#pragma once

#include <cstdint>
#include <string>

#include "bake/export/onnx_graph.h"
#include "model/mesh.h"

namespace fb::bake {

// What the joints of a mesh that has some do in each pose [n, joints, 4, 3]: the columns of the matrices D, of the
// points [n, 3 x vertices] of the mesh, the last of which carry the numbers of joints.
std::string add_joint_changes(OnnxGraph& graph, const Mesh& mesh, const std::string& points);

// Where joints are [n, joints, 3, 4], of what they do.
std::string add_joint_frames(OnnxGraph& graph, const DrivenJoints& driven, const std::string& changes);

// Positions [n, vertices, 1, 3] of the surface where its joints take them. Adds the weights of vertices to
// `parameters`.
std::string add_driven_skin(OnnxGraph& graph, const Mesh& mesh, const std::string& positions,
                            const std::string& changes, std::uint64_t& parameters);

}  // namespace fb::bake
