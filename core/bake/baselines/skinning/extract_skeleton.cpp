#include <algorithm>
#include <cmath>

#include "bake/baselines/skinning/bone_clusters.h"
#include "bake/baselines/skinning/bone_motion.h"
#include "bake/baselines/skinning/bone_weights.h"
#include "bake/regions/surface_graph.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr int smoothing_sweeps = 3;  // of weights over the mesh a round

// Bones without a vertex go; centres become the weighted means of what each bone holds.
void tidy_bones(Skeleton& skeleton, const Mesh& rest) {
  const std::size_t count = skeleton.bone_count();
  std::vector<std::array<double, 4>> sums(count, {0, 0, 0, 0});
  for (std::size_t v = 0; v < rest.vertex_count(); ++v)
    for (std::size_t i = 0; i < bones_a_vertex; ++i) {
      std::array<double, 4>& sum = sums[skeleton.bones[v][i]];
      for (int k = 0; k < 3; ++k) sum[k] += double(skeleton.weights[v][i]) * rest.points[3 * v + k];
      sum[3] += skeleton.weights[v][i];
    }
  std::vector<std::uint32_t> number(count, 0);
  skeleton.centres.clear();
  for (std::size_t b = 0; b < count; ++b) {
    number[b] = static_cast<std::uint32_t>(skeleton.centres.size());
    const auto& [x, y, z, mass] = sums[b];
    if (mass > 0) skeleton.centres.push_back({float(x / mass), float(y / mass), float(z / mass)});
  }
  for (std::size_t v = 0; v < rest.vertex_count(); ++v)
    for (std::size_t i = 0; i < bones_a_vertex; ++i) {
      const bool used = skeleton.weights[v][i] > 0;
      skeleton.bones[v][i] = number[skeleton.bones[v][used ? i : 0]];
    }
}

}  // namespace

Skeleton extract_skeleton(const PoseSet& poses, const SkeletonOptions& options, const Parallel& parallel,
                          Progress& progress) {
  if (poses.size() == 0) fail(Status::bad_data, "there are no poses to find bones in");
  const Mesh& rest = poses.source().rest();
  const HoldoutSet held(poses, options.poses, progress);
  Skeleton skeleton = cluster_vertices(rest, held, std::max(1u, options.bones), parallel, progress);
  const SurfaceGraph graph(rest, {});
  const double smoothing = std::pow(options.smoothing * rest.diagonal(), 2) * static_cast<double>(held.count);
  std::vector<float> transforms;
  progress.begin("fitting bones", options.rounds);
  for (std::uint32_t round = 0; round < options.rounds; ++round) {
    fit_poses(skeleton, rest, held, round == 0 ? 0 : 2, transforms, parallel);
    const BoneMotion motion(skeleton, rest, held, transforms, parallel);
    for (int sweep = 0; sweep < smoothing_sweeps; ++sweep) solve_weights(skeleton, motion, graph, smoothing, parallel);
    progress.step(round + 1);
  }
  tidy_bones(skeleton, rest);
  return skeleton;
}

}  // namespace fb::bake
