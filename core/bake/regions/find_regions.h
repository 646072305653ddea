#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// A set of vertices that one network moves.
struct FaceRegion {
  std::string name;                     // of the control group that moves it most
  std::vector<std::uint32_t> vertices;  // ascending, those of the overlap band included
  std::vector<float> weights;           // blend weight of each vertex, in (0, 1]; a vertex' sum over all regions is 1
  std::vector<std::uint32_t> controls;  // that move its residual: the network's inputs, ascending
  double energy = 0;                    // share of the residual's energy; shares sum to 1
  std::vector<float> motion = {};       // of each control: root mean square over the region's vertices, over D
};

struct RegionOptions {
  // At most; 0: one for every 25 controls that move the residual, 3 to 10. For networks of equal size in total, few
  // wide ones are best where few controls interact and more where many do: `bench_regions REGIONS OVERLAP COMPONENTS
  // SOURCE...` prints what a number of regions, and an overlap, cost.
  std::uint32_t regions = 0;
  // Width of the band that two regions share, along the surface, over the diagonal; at least six edges. 0: hard
  // borders, across which the error jumps. A wider band smooths the jump and costs error elsewhere.
  double overlap = 0.01;
  // A control that moves a region's residual less than this, over the diagonal, is no input of it.
  double motion_threshold = 1e-4;
  std::uint64_t seed = 1;
};

// Splits the vertices with a residual into regions by weighted k-means clustering on the controls that move them
// (residual_motion: controls x vertices, see RigAnalysis) and on their positions. Blend weights are a partition of
// unity: they fall smoothly across a narrow band around each border, measured as geodesic distance along edges, so
// lips, lids, teeth and tongue that touch but are not connected share nothing. Vertices without residual are in no
// region. Fails with invalid_argument on options out of range, not_finite on a motion that is not a distance.
std::vector<FaceRegion> find_regions(const Mesh& rest, const RigSchema& schema, std::span<const float> residual_motion,
                                     const RegionOptions& options);

}  // namespace fb::bake
