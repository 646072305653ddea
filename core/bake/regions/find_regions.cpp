#include "bake/regions/find_regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "bake/regions/surface_graph.h"
#include "bake/regions/weighted_kmeans.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t no_region = UINT32_MAX;

// Vertices join a region from this part of the motion threshold on, so that motion ends below what is visible.
constexpr double clustered_motion = 0.1;
// Smaller connected components of a region join a neighbour.
constexpr std::size_t min_component_vertices = 12;
// Minimum width of an overlap band in edges, for coarse meshes.
constexpr double min_band_edges = 6;

// Number of regions, see RegionOptions::regions.
constexpr std::size_t controls_per_region = 25, min_regions = 3, max_regions = 10;

// How far each control moves the residual of each vertex, with statistics of the vertices.
struct ResidualMotion {
  std::span<const float> values;  // controls x vertices
  std::size_t vertices;
  std::vector<double> energy;  // one a vertex: squared motions summed over controls
  std::vector<float> largest;  // one a vertex

  std::size_t controls() const { return values.size() / vertices; }
  float at(std::size_t control, std::size_t vertex) const { return values[control * vertices + vertex]; }
};

ResidualMotion read_motion(const Mesh& rest, const RigSchema& schema, std::span<const float> values) {
  ResidualMotion motion{values, rest.vertex_count(), {}, {}};
  if (values.size() != schema.control_count() * motion.vertices)
    fail(Status::invalid_argument, "%zu motions given for %zu controls and %zu vertices", values.size(),
         schema.control_count(), motion.vertices);
  motion.energy.assign(motion.vertices, 0);
  motion.largest.assign(motion.vertices, 0);
  for (std::size_t c = 0; c < motion.controls(); ++c)
    for (std::size_t v = 0; v < motion.vertices; ++v) {
      const float m = motion.at(c, v);
      if (!(m >= 0) || m == INFINITY)
        fail(Status::not_finite, "the motion of vertex %zu by control \"%s\" is not a distance", v,
             schema.controls[c].name.c_str());
      motion.energy[v] += double(m) * m;
      motion.largest[v] = std::max(motion.largest[v], m);
    }
  return motion;
}

// Pairs of vertices with equal positions and equal motion by every control: duplicates, split for texture coordinates
// for example, which must not separate.
std::vector<std::pair<std::uint32_t, std::uint32_t>> duplicate_vertices(const Mesh& rest,
                                                                        const ResidualMotion& motion) {
  std::vector<std::uint32_t> order(rest.vertex_count());
  std::iota(order.begin(), order.end(), 0u);
  const auto compare = [&](std::uint32_t a, std::uint32_t b) {
    const float *p = rest.points.data() + 3 * std::size_t(a), *q = rest.points.data() + 3 * std::size_t(b);
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] != q[axis]) return p[axis] < q[axis] ? -1 : 1;
    if (motion.energy[a] != motion.energy[b]) return motion.energy[a] < motion.energy[b] ? -1 : 1;
    for (std::size_t c = 0; c < motion.controls(); ++c)
      if (motion.at(c, a) != motion.at(c, b)) return motion.at(c, a) < motion.at(c, b) ? -1 : 1;
    return 0;
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const int sign = compare(a, b);
    return sign ? sign < 0 : a < b;
  });
  std::vector<std::pair<std::uint32_t, std::uint32_t>> duplicates;
  for (std::size_t i = 1; i < order.size(); ++i)
    if (compare(order[i - 1], order[i]) == 0) duplicates.emplace_back(order[i - 1], order[i]);
  return duplicates;
}

// The number of regions for the controls that move the residual.
std::size_t region_count(const ResidualMotion& motion, double motion_threshold) {
  std::size_t moving = 0;
  for (std::size_t c = 0; c < motion.controls(); ++c) {
    const std::span<const float> of_control = motion.values.subspan(c * motion.vertices, motion.vertices);
    moving += *std::max_element(of_control.begin(), of_control.end()) > motion_threshold;
  }
  return std::clamp(moving / controls_per_region, min_regions, max_regions);
}

// The cluster of each vertex that moves, no_region for the others. Features of the clustering: the square roots of the
// controls' shares of the vertex' motion (square roots, so that weak controls count too) and the position over half
// the diagonal. Weights: the vertex' energy.
std::vector<std::uint32_t> cluster_vertices(const Mesh& rest, const ResidualMotion& motion,
                                            const RegionOptions& options) {
  std::vector<std::uint32_t> labels(motion.vertices, no_region), moved;
  for (std::uint32_t v = 0; v < motion.vertices; ++v)
    if (motion.largest[v] > clustered_motion * options.motion_threshold) moved.push_back(v);
  if (moved.empty()) return labels;

  const std::size_t width = motion.controls() + 3;
  const double diagonal = rest.diagonal();
  std::vector<float> features(moved.size() * width);
  std::vector<double> weights;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    float* feature = features.data() + i * width;
    double sum = 0;
    for (std::size_t c = 0; c < motion.controls(); ++c) sum += motion.at(c, moved[i]);
    for (std::size_t c = 0; c < motion.controls(); ++c)
      feature[c] = static_cast<float>(std::sqrt(motion.at(c, moved[i]) / sum));
    for (std::size_t axis = 0; axis < 3; ++axis)
      feature[motion.controls() + axis] =
          static_cast<float>(2 * rest.points[3 * std::size_t(moved[i]) + axis] / diagonal);
    weights.push_back(motion.energy[moved[i]]);
  }
  const std::vector<std::uint32_t> found =
      weighted_kmeans(features, width, weights,
                      {.clusters = options.regions ? options.regions : region_count(motion, options.motion_threshold),
                       .min_cluster_size = min_component_vertices,
                       .seed = seed_of(options.seed, Stream::regions)});
  for (std::size_t i = 0; i < moved.size(); ++i) labels[moved[i]] = found[i];
  return labels;
}

// Connected components that are small, or move no further than the threshold, join the region they share most edges
// with; those that do not move and touch no region leave theirs.
void merge_small_components(const SurfaceGraph& graph, const ResidualMotion& motion, double motion_threshold,
                            std::vector<std::uint32_t>& labels) {
  for (bool changed = true; changed;) {
    changed = false;
    for (const std::vector<std::uint32_t>& component : graph.components(labels)) {
      const std::uint32_t own = labels[component[0]];
      const bool idle = std::none_of(component.begin(), component.end(),
                                     [&](auto v) { return motion.largest[v] > motion_threshold; });
      if (own == no_region || (component.size() >= min_component_vertices && !idle)) continue;
      std::map<std::uint32_t, std::size_t> shared_edges;
      for (const std::uint32_t v : component)
        for (const SurfaceGraph::Edge& edge : graph.edges(v))
          if (labels[edge.vertex] != no_region && labels[edge.vertex] != own) ++shared_edges[labels[edge.vertex]];
      if (shared_edges.empty() && !idle) continue;
      const auto most = std::max_element(shared_edges.begin(), shared_edges.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      for (const std::uint32_t v : component) labels[v] = shared_edges.empty() ? no_region : most->first;
      changed = true;
      break;  // the components have changed
    }
  }
}

// Renumbers the remaining labels from 0 without gaps; returns their count.
std::uint32_t renumber(std::vector<std::uint32_t>& labels) {
  std::map<std::uint32_t, std::uint32_t> numbers;
  for (const std::uint32_t label : labels)
    if (label != no_region) numbers.emplace(label, 0);
  std::uint32_t count = 0;
  for (auto& [label, number] : numbers) number = count++;
  for (std::uint32_t& label : labels)
    if (label != no_region) label = numbers.at(label);
  return count;
}

// Blend weights of every vertex in each region, a partition of unity: 1 inside, 0 outside, and a smoothstep of the
// geodesic distance across a band around the border.
std::vector<std::vector<float>> blend_weights(const SurfaceGraph& graph, const std::vector<std::uint32_t>& labels,
                                              std::uint32_t count, double band) {
  std::vector<char> moved(labels.size());
  for (std::size_t v = 0; v < labels.size(); ++v) moved[v] = labels[v] != no_region;
  const double max_edge = band / min_band_edges;
  std::vector<std::vector<float>> weights(count, std::vector<float>(labels.size(), 0));
  for (std::uint32_t region = 0; region < count; ++region) {
    std::vector<double> distance(labels.size(), INFINITY);
    for (std::uint32_t v = 0; v < labels.size(); ++v) {
      if (!moved[v]) continue;
      for (const SurfaceGraph::Edge& edge : graph.edges(v))
        if (moved[edge.vertex] && (labels[v] == region) != (labels[edge.vertex] == region))
          distance[v] = std::min(distance[v], std::min<double>(edge.length, max_edge) / 2);
    }
    if (band > 0) graph.geodesic_distances(distance, moved, max_edge, band / 2);
    for (std::size_t v = 0; v < labels.size(); ++v) {
      if (!moved[v]) continue;
      const bool inside = labels[v] == region;
      weights[region][v] = inside;
      if (band <= 0 || distance[v] >= band / 2) continue;
      const double t = 0.5 + (inside ? distance[v] : -distance[v]) / band;
      weights[region][v] = static_cast<float>(t * t * (3 - 2 * t));
    }
  }
  for (std::size_t v = 0; v < labels.size(); ++v) {
    float sum = 0;
    for (const std::vector<float>& region_weights : weights) sum += region_weights[v];
    for (std::vector<float>& region_weights : weights)
      if (region_weights[v] > 0) region_weights[v] /= sum;
  }
  return weights;
}

FaceRegion make_region(const RigSchema& schema, const ResidualMotion& motion, const std::vector<float>& weights,
                       double motion_threshold) {
  FaceRegion region;
  for (std::uint32_t v = 0; v < weights.size(); ++v) {
    if (weights[v] <= 0) continue;
    region.vertices.push_back(v);
    region.weights.push_back(weights[v]);
    region.energy += weights[v] * motion.energy[v];
  }
  std::map<std::string, double> influence;
  for (std::uint32_t c = 0; c < motion.controls(); ++c) {
    double squares = 0;
    float largest = 0;
    for (std::size_t i = 0; i < region.vertices.size(); ++i) {
      const float m = motion.at(c, region.vertices[i]);
      squares += region.weights[i] * double(m) * m;
      largest = std::max(largest, region.weights[i] * m);
    }
    if (largest > motion_threshold) {
      region.controls.push_back(c);
      region.motion.push_back(static_cast<float>(std::sqrt(squares / double(region.vertices.size()))));
    }
    influence[schema.controls[c].group] += squares;
  }
  region.name = std::max_element(influence.begin(), influence.end(), [](const auto& a, const auto& b) {
                  return a.second < b.second;
                })->first;
  return region;
}

// Makes names unique: "mouth", "mouth 2", "mouth 3".
void make_names_unique(std::vector<FaceRegion>& regions) {
  std::set<std::string> taken;
  for (FaceRegion& region : regions) {
    const std::string group = region.name.empty() ? "region" : region.name;
    region.name = group;
    for (int number = 2; !taken.insert(region.name).second; ++number)
      region.name = group + " " + std::to_string(number);
  }
}

}  // namespace

std::vector<FaceRegion> find_regions(const Mesh& rest, const RigSchema& schema, std::span<const float> residual_motion,
                                     const RegionOptions& options) {
  if (!(options.overlap >= 0) || !(options.motion_threshold > 0))
    fail(Status::invalid_argument,
         "regions need an overlap of at least 0 and a motion threshold above 0, not %g and %g", options.overlap,
         options.motion_threshold);
  const ResidualMotion motion = read_motion(rest, schema, residual_motion);
  std::vector<std::uint32_t> labels = cluster_vertices(rest, motion, options);
  const SurfaceGraph graph(rest, duplicate_vertices(rest, motion));
  merge_small_components(graph, motion, options.motion_threshold, labels);
  const std::uint32_t count = renumber(labels);

  std::vector<FaceRegion> regions;
  double total = 0;
  for (const std::vector<float>& weights : blend_weights(graph, labels, count, options.overlap * rest.diagonal())) {
    regions.push_back(make_region(schema, motion, weights, options.motion_threshold));
    total += regions.back().energy;
  }
  for (FaceRegion& region : regions) region.energy /= total;
  std::stable_sort(regions.begin(), regions.end(),
                   [](const FaceRegion& a, const FaceRegion& b) { return a.energy > b.energy; });
  make_names_unique(regions);
  return regions;
}

}  // namespace fb::bake
