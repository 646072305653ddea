#include <algorithm>
#include <cmath>

#include "bake/baselines/skinning/bone_clusters.h"
#include "bake/baselines/skinning/bone_motion.h"
#include "bake/baselines/skinning/bone_weights.h"
#include "bake/regions/surface_graph.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr int smoothing_sweeps = 3;  // of the weights over the mesh, per round

// Drops bones without vertices and sets centres to the weighted means of the bones' vertices.
void clean_up_bones(Skeleton& skeleton, const Mesh& rest) {
  const std::size_t count = skeleton.bone_count();
  std::vector<std::array<double, 4>> sums(count, {0, 0, 0, 0});
  for (std::size_t v = 0; v < rest.vertex_count(); ++v)
    for (std::size_t i = 0; i < bones_per_vertex; ++i) {
      std::array<double, 4>& sum = sums[skeleton.bones[v][i]];
      for (int k = 0; k < 3; ++k) sum[k] += double(skeleton.weights[v][i]) * rest.points[3 * v + k];
      sum[3] += skeleton.weights[v][i];
    }
  std::vector<std::uint32_t> new_index(count, 0);
  skeleton.centres.clear();
  for (std::size_t b = 0; b < count; ++b) {
    new_index[b] = static_cast<std::uint32_t>(skeleton.centres.size());
    const auto& [x, y, z, mass] = sums[b];
    if (mass > 0) skeleton.centres.push_back({float(x / mass), float(y / mass), float(z / mass)});
  }
  for (std::size_t v = 0; v < rest.vertex_count(); ++v)
    for (std::size_t i = 0; i < bones_per_vertex; ++i) {
      const bool used = skeleton.weights[v][i] > 0;
      skeleton.bones[v][i] = new_index[skeleton.bones[v][used ? i : 0]];
    }
}

Skeleton skeleton_of_sample(const Mesh& rest, const PoseSample& sample, const SkeletonOptions& options,
                            const Parallel& parallel, Progress& progress) {
  Skeleton skeleton = cluster_bones(rest, sample, std::max(1u, options.bones), parallel, progress);
  const SurfaceGraph graph(rest, {});
  const double smoothing = std::pow(options.smoothing * rest.diagonal(), 2) * static_cast<double>(sample.count);
  std::vector<float> transforms;
  progress.begin(Phase::analysis, "fitting bones", options.rounds);
  for (std::uint32_t round = 0; round < options.rounds; ++round) {
    fit_poses(skeleton, rest, sample, round == 0 ? 0 : 2, transforms, parallel);
    const BoneMotion motion(skeleton, rest, sample, transforms, parallel);
    for (int sweep = 0; sweep < smoothing_sweeps; ++sweep) solve_weights(skeleton, motion, graph, smoothing, parallel);
    progress.step(round + 1);
  }
  clean_up_bones(skeleton, rest);
  return skeleton;
}

}  // namespace

Skeleton extract_skeleton(const PoseSet& poses, const SkeletonOptions& options, const Parallel& parallel,
                          Progress& progress) {
  if (poses.size() == 0) fail(Status::bad_data, "there are no poses to extract bones from");
  return skeleton_of_sample(poses.source().rest(), PoseSample(poses, options.poses, progress), options, parallel,
                            progress);
}

Skeleton extract_skeleton(const Mesh& rest, std::span<const float> points, const SkeletonOptions& options,
                          const Parallel& parallel, Progress& progress) {
  return skeleton_of_sample(rest, PoseSample(rest, points), options, parallel, progress);
}

std::vector<float> fit_transforms(const Skeleton& skeleton, const Mesh& rest, std::span<const float> points,
                                  std::uint32_t sweeps, const Parallel& parallel) {
  std::vector<float> transforms;
  fit_poses(skeleton, rest, PoseSample(rest, points), sweeps, transforms, parallel);
  return transforms;
}

}  // namespace fb::bake
