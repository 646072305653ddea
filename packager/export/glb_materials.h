#pragma once

#include <string>
#include <vector>

#include "export/character_view.h"
#include "export/glb_buffer.h"

namespace fb::tool {

// Adds a character's images, as the files they are, and its materials, in the character's order; a clay material where
// it has none. What glTF does not hold is left out and named in `notes`: images of other types than PNG, JPEG, KTX2
// (KHR_texture_basisu) and WebP (EXT_texture_webp), images without bytes, and textures where the character has no
// texture coordinates. Factors outside glTF's ranges are clamped, except emissive ones
// (KHR_materials_emissive_strength).
void add_materials(tinygltf::Model& model, GlbBuffer& buffer, const CharacterView& character,
                   std::vector<std::string>& notes);

// The index in a .glb of the material of a run; negative: glTF's default.
int material_of(const CharacterView& character, const fb_material_run& run);

}  // namespace fb::tool
