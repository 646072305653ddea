#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// A part of the face with a network of its own.
struct FaceRegion {
  std::string name;                     // of the control group that moves it most
  std::vector<std::uint32_t> vertices;  // ascending; with its share of the overlap
  std::vector<float> weights;           // one a vertex, in (0, 1]; over all regions a vertex' weights sum to 1
  std::vector<std::uint32_t> controls;  // that move its residual: the network's inputs, ascending
  double energy = 0;                    // its share of the residual's energy; shares sum to 1
};

struct RegionOptions {
  std::uint32_t regions = 0;  // at most; 0: one for every 25 controls that move the residual, 3 to 10
  // Width of the band two regions share, along the surface, over the diagonal; at least six edges wide, unless 0, which
  // makes hard borders.
  double overlap = 0.01;
  double still = 1e-4;  // a control that moves the residual of a region less (over D) is no input of it
  std::uint64_t seed = 1;
};

// Splits the vertices whose residual moves by weighted k-means on what moves them (residual_motion: controls x
// vertices, see RigAnalysis) and where they are; borders overlap in a narrow band measured along edges, across which
// weights blend smoothly, so nothing is shared between lips, lids, teeth and tongue that touch but are not joined.
// Vertices whose residual nothing moves are in no region.
std::vector<FaceRegion> find_regions(const Mesh& rest, const RigSchema& schema, std::span<const float> residual_motion,
                                     const RegionOptions& options);

}  // namespace fb::bake
