#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bake/rig/gltf/gltf_scene.h"
#include "bake/rig/gltf/left_out.h"

namespace fb::bake {

// The controls of the shown meshes. A control is all morph targets of one name: it moves every mesh that has one.
struct GltfControls {
  std::vector<std::string> names;
  std::vector<float> rest;                         // default weights
  std::vector<std::vector<std::size_t>> of_shown;  // for each shown mesh the control of each of its morph targets
};

// Names are those of extras.targetNames; without these, target0, target1, ..., preceded by the name of the mesh where
// several meshes have none. A target whose name is missing is "MESH target 3", and of two with one name in a mesh the
// second is "NAME 2", with notes. Of default weights that contradict each other the first counts; those that are
// missing are 0.
GltfControls read_controls(const GltfFile& file, const std::vector<ShownMesh>& shown, LeftOut& left_out);

}  // namespace fb::bake
