// Two cages round the mouth, one for either lip: lattices whose points bones move, that keep off the teeth and resist
// being drawn apart. Vertices inside follow them.
#pragma once

#include <array>
#include <vector>

#include "production/face_bone.h"

namespace rigs::production {

class LipCage {
 public:
  LipCage(const FaceMesh& mesh, const std::vector<FaceBone>& bones);

  // Draws points towards where the cages have them.
  void apply(const std::vector<Motion>& motions, Vec* points) const;

 private:
  static constexpr int nx = 7, ny = 4, nz = 2, size = nx * ny * nz;
  using Lattice = std::array<Vec, size>;
  struct Pull {
    std::size_t bone;
    float weight;
  };
  struct Bound {
    std::size_t vertex;
    Vec rest;
    float share;  // of the cages in its place
    float upper;  // of the upper cage in that of the cages
    std::array<int, 8> corners;
    std::array<float, 8> weights;
  };

  void bind(std::size_t vertex, Vec point, Part part);
  Lattice posed(int cage, const std::vector<Motion>& motions) const;

  Lattice rest_;
  std::array<std::vector<Pull>, 2 * size> pulls_;  // of the points of the upper cage, then of the lower
  std::vector<Bound> bound_;
};

}  // namespace rigs::production
