#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "export/character_view.h"
#include "export/low_rank.h"

namespace fb::tool {

struct UsdScene {
  const CharacterView& character;
  std::size_t frames = 1;  // 1: a still pose
  double fps = 30;
  FrameReader positions;  // frames x 3 x vertices of all meshes
  std::string licence;    // may be empty, like about
  std::string about;      // a JSON object
};

// Writes a scene as text of USD (.usda; openusd.org): a component of one Mesh prim a mesh, with the rig's own polygons,
// texture coordinates by corner as primvars:st, and points with a time sample a frame, beside the default of the first
// frame; materials as UsdPreviewSurface without textures. Names that are no identifiers are in displayName. `progress`
// is told each frame of each mesh. Gives what is left out, in sentences.
std::vector<std::string> write_usda(const std::filesystem::path& path, const UsdScene& scene,
                                    const std::function<void(std::size_t done)>& progress);

}  // namespace fb::tool
