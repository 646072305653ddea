// How a mesh moves in a .glb.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace fb::tool {

// Morph targets of one mesh, with weights: points of frame f = base + sum over targets t of
// weights[f][t] * displacements[t].
struct MorphTargets {
  std::size_t count = 0;             // of targets
  std::vector<float> displacements;  // targets x 3 x vertices
  std::vector<float> normals;        // as many: change of the normals for one unit of weight; empty: not yet known
  std::vector<float> weights;        // frames x targets
  std::vector<std::string> names;    // of the targets; empty: they have none

  std::span<const float> target(std::size_t t) const { return part(displacements, t); }
  std::span<const float> target_normals(std::size_t t) const { return part(normals, t); }
  // Adds a target without weights and normals.
  void add(std::span<const float> displacement);
  // Bytes of a .glb that they take, about.
  std::size_t stored_bytes() const;

 private:
  std::span<const float> part(const std::vector<float>& vectors, std::size_t t) const {
    return std::span(vectors).subspan(t * (vectors.size() / count), vectors.size() / count);
  }
};

// How far points that morph targets give lie from evaluated ones.
struct MorphError {
  double largest = 0;  // distance, in the rig's unit
  double squares = 0;  // of distances, summed
  std::size_t points = 0;

  double rms() const;
  void add(const MorphError& other);
};

// Adds what frames of a mesh, evaluated displacements (3 x vertices each) from the base, lie from the sum of the
// targets with `weights` (frames x targets).
MorphError morph_error(const MorphTargets& morph, std::span<const float> weights, std::span<const float> displacements,
                       std::size_t frames);

}  // namespace fb::tool
