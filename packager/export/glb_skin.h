#pragma once

#include <map>
#include <string>
#include <vector>

#include "export/character_view.h"
#include "export/glb_buffer.h"
#include "export/uv_seams.h"

namespace fb::tool {

// Whether the vertices of a mesh follow joints.
bool is_skinned(const CharacterView& character, std::size_t mesh);

// Adds the joints of a character as nodes, and one skin of all of them. A skeleton of one root stands beside the upper
// node, which the model has, with the upper node's transform in that of the root; a skeleton of several below it. Gives
// their nodes, in order.
std::vector<int> add_joints(tinygltf::Model& model, GlbBuffer& buffer, const CharacterView& character);

// Adds joints and weights, four in each attribute, to those of a mesh that is skinned.
void add_influences(tinygltf::Model& model, std::map<std::string, int>& attributes, GlbBuffer& buffer,
                    const CharacterView& character, std::size_t mesh, const SplitMesh& split);

}  // namespace fb::tool
