#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "export/character_view.h"
#include "export/morph_targets.h"

namespace fb::tool {

struct GlbScene {
  const CharacterView& character;
  std::span<const float> points;     // of all meshes, 3 x vertices
  std::vector<MorphTargets> morphs;  // of each mesh; the weights have `frames` frames
  std::vector<float> socket_frames;  // frames x sockets x 12
  std::size_t frames = 1;            // 1: a still pose
  double fps = 30;
};

// Writes a binary glTF 2.0: a node for each mesh and each socket under one that scales to metres and turns y up, with
// materials and images; joints and a skin, with the nodes of meshes that it moves beside that node; one animation if
// there are several frames. A face whose one mesh has no name has it in the upper node. Units other than "m", "dm",
// "cm", "mm", "in" and "ft" are not scaled. Gives what is left out, in sentences.
std::vector<std::string> write_glb(const std::filesystem::path& path, const GlbScene& scene);

}  // namespace fb::tool
