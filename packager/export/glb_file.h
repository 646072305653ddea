#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "model/mesh.h"

namespace fb {

// A mesh that moves as glTF moves meshes: points of frame f = base + sum over targets t of weights[f][t] * targets[t].
struct MorphAnimation {
  std::vector<std::vector<float>> targets;  // each 3 x vertices displacements
  std::vector<float> weights;               // frames x targets
  double fps = 30;

  std::size_t frames() const { return targets.empty() ? 0 : weights.size() / targets.size(); }
};

struct GlbScene {
  std::string name;
  std::string units =
      "m";  // "m", "dm", "cm", "mm", "in", "ft": the node is scaled to glTF's metres; others: not scaled
  std::string up_axis = "y";    // "z": the node is turned to glTF's y
  const Mesh* topology;         // triangulated; every vertex is kept, in order
  std::span<const float> base;  // 3 x vertices, in units
  MorphAnimation animation;     // no targets: a still
};

// Writes a binary glTF 2.0 with positions, normals, triangles and texture coordinates if there are any, for which
// vertices on seams are copied after all others. Positions are exact; targets that move less than half of the vertices
// are stored sparsely. Normals of a target are exact where its weight is its largest of the animation.
void write_glb(const std::filesystem::path& path, const GlbScene& scene);

}  // namespace fb
