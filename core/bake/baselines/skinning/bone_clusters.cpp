// Splitting and reassignment as in vector quantisation (Linde, Buzo, Gray, IEEE Trans. Comm. 28, 1980), with rigid
// motions in place of means: the clusters with the largest errors are split in two, and vertices are reassigned to the
// cluster whose motion fits them best.
#include "bake/baselines/skinning/bone_clusters.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

namespace fb::bake {
namespace {

constexpr int reassignments_per_round = 3;
constexpr std::size_t min_split_vertices = 8;  // of a cluster that is split

struct Clusters {
  std::uint32_t count = 1;
  std::vector<std::uint32_t> labels;  // of vertices
  std::vector<double> errors;         // of vertices: squared distance summed over all poses
};

Skeleton skeleton_of(const Clusters& clusters, const std::array<float, 3>& centre) {
  Skeleton skeleton;
  skeleton.centres.assign(clusters.count, centre);
  for (const std::uint32_t label : clusters.labels) {
    skeleton.bones.push_back({label, label, label, label});
    skeleton.weights.push_back({1, 0, 0, 0});
  }
  return skeleton;
}

// Removes empty clusters and renumbers the others.
void drop_empty(Clusters& clusters) {
  std::vector<std::uint32_t> number(clusters.count, 0), sizes(clusters.count, 0);
  for (const std::uint32_t label : clusters.labels) ++sizes[label];
  std::uint32_t kept = 0;
  for (std::uint32_t c = 0; c < clusters.count; ++c) {
    number[c] = kept;
    kept += sizes[c] > 0;
  }
  for (std::uint32_t& label : clusters.labels) label = number[label];
  clusters.count = kept;
}

// Assigns each vertex to the cluster with the least error, and updates the errors.
void reassign_vertices(Clusters& clusters, const Mesh& rest, const PoseSample& poses,
                       const std::array<float, 3>& centre, const Parallel& parallel) {
  const Skeleton skeleton = skeleton_of(clusters, centre);
  std::vector<float> transforms;
  fit_poses(skeleton, rest, poses, 0, transforms, parallel);
  const BoneMotion motion(skeleton, rest, poses, transforms, parallel);
  parallel_for(parallel, rest.vertex_count(), [&](std::size_t v, std::size_t) {
    double best = std::numeric_limits<double>::infinity();
    for (std::uint32_t b = 0; b < clusters.count; ++b)
      if (const double error = motion.error(v, b); error < best) {
        best = error;
        clusters.labels[v] = b;
      }
    clusters.errors[v] = std::max(0.0, best + double(poses.trajectories.col(v).squaredNorm()));
  });
  drop_empty(clusters);
}

// Splits the half of the clusters with the larger errors: a vertex with a large error far from the centre becomes the
// seed of a new cluster, which gets the vertices nearer to it than to the centre. False if none was split.
bool split_worst(Clusters& clusters, const Mesh& rest, std::uint32_t max_count) {
  std::vector<double> errors(clusters.count, 0.0);
  std::vector<std::vector<std::uint32_t>> members(clusters.count);
  for (std::uint32_t v = 0; v < clusters.labels.size(); ++v) {
    errors[clusters.labels[v]] += clusters.errors[v];
    members[clusters.labels[v]].push_back(v);
  }
  std::vector<std::uint32_t> order(clusters.count);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return errors[a] > errors[b]; });
  const std::uint32_t before = clusters.count, wanted = std::max(1u, (before + 1) / 2);
  for (std::uint32_t i = 0; i < wanted && clusters.count < max_count; ++i) {
    const std::vector<std::uint32_t>& cluster = members[order[i]];
    if (cluster.size() < min_split_vertices || !(errors[order[i]] > 0)) continue;
    const auto point = [&](std::uint32_t v) { return Eigen::Map<const Eigen::Vector3f>(rest.points.data() + 3 * v); };
    Eigen::Vector3f centre = Eigen::Vector3f::Zero();
    for (const std::uint32_t v : cluster) centre += point(v) / static_cast<float>(cluster.size());
    std::uint32_t seed = cluster[0];
    double worst = -1;
    for (const std::uint32_t v : cluster)
      if (const double score = clusters.errors[v] * (point(v) - centre).squaredNorm(); score > worst) {
        worst = score;
        seed = v;
      }
    for (const std::uint32_t v : cluster)
      if ((point(v) - point(seed)).squaredNorm() < (point(v) - centre).squaredNorm())
        clusters.labels[v] = clusters.count;
    clusters.labels[seed] = clusters.count++;
  }
  return clusters.count > before;
}

}  // namespace

Skeleton cluster_bones(const Mesh& rest, const PoseSample& poses, std::uint32_t bones, const Parallel& parallel,
                       Progress& progress) {
  const std::size_t vertices = rest.vertex_count();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t v = 0; v < vertices; ++v)
    mean += Eigen::Map<const Eigen::Vector3f>(rest.points.data() + 3 * v).cast<double>() / double(vertices);
  const std::array<float, 3> centre = {float(mean[0]), float(mean[1]), float(mean[2])};

  Clusters clusters{1, std::vector<std::uint32_t>(vertices, 0), std::vector<double>(vertices, 0.0)};
  const int rounds = 4 + 2 * static_cast<int>(std::bit_width(bones));  // a round adds half as many; plus a reserve
  progress.begin(Phase::analysis, "clustering vertices", rounds);
  for (int round = 0; round < rounds; ++round) {
    for (int i = 0; i < reassignments_per_round; ++i) reassign_vertices(clusters, rest, poses, centre, parallel);
    progress.step(round + 1);
    if (round + 1 == rounds || clusters.count >= bones || !split_worst(clusters, rest, bones)) break;
  }
  return skeleton_of(clusters, centre);
}

}  // namespace fb::bake
