#pragma once

#include <memory>

#include "export/character_view.h"
#include "render/appearance.h"

namespace fb::tool {

// How a character is drawn with its materials: base and emissive colour, the base colour's texture, and transparency.
// A surface that lets through half of what is behind it or more is not drawn. Polygons without a material are of clay.
// Null if the materials say nothing of colours, or there are none. notes: gets a sentence on each texture that is not
// shown, as it is no PNG, JPEG or WebP, or broken; may be null.
std::shared_ptr<const Appearance> appearance_of(const CharacterView& character,
                                                std::vector<std::string>* notes = nullptr);

}  // namespace fb::tool
