#pragma once

#include <string>
#include <vector>

#include "export/character_view.h"

namespace fb::tool {

// Materials of a character as USD's UsdPreviewSurface, without textures.
class UsdaMaterials {
 public:
  // root: the path of the prim that has them in a scope of this name. The character must outlive this.
  UsdaMaterials(const CharacterView& character, const std::string& root, const std::string& scope);

  // Whether polygons of a mesh have a material.
  bool binds(std::size_t mesh) const;
  // What belongs into the prim of a mesh: one binding, or subsets of its polygons with one each.
  std::string binding(std::size_t mesh) const;
  // The prim that defines them; empty without materials.
  std::string scope() const;

 private:
  const CharacterView& character_;
  std::string root_, scope_;
  std::vector<std::string> prims_;  // of each material
};

}  // namespace fb::tool
