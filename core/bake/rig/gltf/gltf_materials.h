#pragma once

#include <vector>

#include "bake/rig/gltf/gltf_file.h"
#include "bake/rig/gltf/left_out.h"
#include "model/character.h"
#include "model/mesh.h"

namespace fb::bake {

// Reads the materials that runs of the parts have, whose indices are those of the file, and sets these to the materials
// that are returned: those that are used, with the images that their textures use, both in the order of the file.
// Images stay the files they are: PNG, JPEG, KTX2 or WebP. Fails, naming material or image, on what there is not.
Character read_gltf_materials(const GltfFile& file, std::vector<MeshPart>& parts, LeftOut& left_out);

}  // namespace fb::bake
