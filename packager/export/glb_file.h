#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "render/mesh_view.h"

namespace fb::tool {

// Morph targets with animated weights: points of frame f = base + sum over targets t of weights[f][t] * targets[t].
struct MorphAnimation {
  std::vector<std::vector<float>> targets;  // displacements, 3 x vertices each
  std::vector<float> weights;               // frames x targets
  double fps = 30;

  std::size_t frames() const { return targets.empty() ? 0 : weights.size() / targets.size(); }
};

struct GlbScene {
  std::string name;
  std::string units;            // "m", "dm", "cm", "mm", "in", "ft": the node is scaled to metres; others: not scaled
  std::string up_axis;          // "z": the node is turned to y up
  MeshView mesh;                // is triangulated; keeps all vertices in order
  std::span<const float> base;  // points of the mesh, 3 x vertices
  MorphAnimation animation;     // without targets: a still pose
};

// Writes a binary glTF 2.0 with positions, normals, triangles and, if there are any, texture coordinates; for these,
// vertices on UV seams are duplicated after all others. Positions are exact; targets that move less than half of the
// vertices are stored as sparse accessors. The normals of a target are exact at its largest weight.
void write_glb(const std::filesystem::path& path, const GlbScene& scene);

}  // namespace fb::tool
