#include "bake/regions/find_regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "bake/regions/surface_graph.h"
#include "bake/regions/weighted_kmeans.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t nowhere = UINT32_MAX;

// A region ends where its residual is this part of `still`, so that nothing is seen to stop moving.
constexpr double fade = 0.1;
// A piece of a region with fewer vertices than this joins what surrounds it.
constexpr std::size_t smallest_piece = 12;
// The band of an overlap is at least so many edges wide, however coarse the mesh.
constexpr double band_edges = 6;

// Of networks of equal size in all, few wide ones are best where few controls interact, more where many do.
constexpr std::size_t controls_per_region = 25, fewest_regions = 3, most_regions = 10;

// residual_motion, seen from the vertices.
struct Motion {
  std::span<const float> values;  // controls x vertices
  std::size_t vertices;
  std::vector<double> energy;  // of a vertex: squared motions summed over controls
  std::vector<float> largest;  // of a vertex

  std::size_t controls() const { return values.size() / vertices; }
  float at(std::size_t control, std::size_t vertex) const { return values[control * vertices + vertex]; }
};

Motion look_at(const Mesh& rest, const RigSchema& schema, std::span<const float> values) {
  Motion motion{values, rest.vertex_count(), {}, {}};
  if (values.size() != schema.control_count() * motion.vertices)
    fail(Status::invalid_argument, "%zu motions given for %zu controls and %zu vertices", values.size(),
         schema.control_count(), motion.vertices);
  motion.energy.assign(motion.vertices, 0);
  motion.largest.assign(motion.vertices, 0);
  for (std::size_t c = 0; c < motion.controls(); ++c)
    for (std::size_t v = 0; v < motion.vertices; ++v) {
      const float m = motion.at(c, v);
      if (!(m >= 0) || m == INFINITY)
        fail(Status::not_finite, "the motion of vertex %zu by control \"%s\" is no distance", v,
             schema.controls[c].name.c_str());
      motion.energy[v] += double(m) * m;
      motion.largest[v] = std::max(motion.largest[v], m);
    }
  return motion;
}

// Vertices at one place that every control moves alike: one vertex that was split, by texture coordinates say, and must
// not come apart.
std::vector<std::pair<std::uint32_t, std::uint32_t>> split_vertices(const Mesh& rest, const Motion& motion) {
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
  std::vector<std::pair<std::uint32_t, std::uint32_t>> same;
  for (std::size_t i = 1; i < order.size(); ++i)
    if (compare(order[i - 1], order[i]) == 0) same.emplace_back(order[i - 1], order[i]);
  return same;
}

// How many regions serve the controls that move the residual at all.
std::size_t enough_regions(const Motion& motion, double still) {
  std::size_t moving = 0;
  for (std::size_t c = 0; c < motion.controls(); ++c) {
    const std::span<const float> of_control = motion.values.subspan(c * motion.vertices, motion.vertices);
    moving += *std::max_element(of_control.begin(), of_control.end()) > still;
  }
  return std::clamp(moving / controls_per_region, fewest_regions, most_regions);
}

// Clusters of the vertices that move, by direction in the space of the controls' influence (square roots, so that weak
// controls count too) and by place; vertices that move far pull harder.
std::vector<std::uint32_t> cluster(const Mesh& rest, const Motion& motion, const RegionOptions& options) {
  std::vector<std::uint32_t> labels(motion.vertices, nowhere), moved;
  for (std::uint32_t v = 0; v < motion.vertices; ++v)
    if (motion.largest[v] > fade * options.still) moved.push_back(v);
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
                      {.clusters = options.regions ? options.regions : enough_regions(motion, options.still),
                       .smallest = smallest_piece,
                       .seed = options.seed});
  for (std::size_t i = 0; i < moved.size(); ++i) labels[moved[i]] = found[i];
  return labels;
}

// Small pieces, and ones that move no further than `still`, join the region they touch most; idle ones that touch none
// are in no region.
void join_fragments(const SurfaceGraph& graph, const Motion& motion, double still, std::vector<std::uint32_t>& labels) {
  for (bool changed = true; changed;) {
    changed = false;
    for (const std::vector<std::uint32_t>& piece : graph.pieces(labels)) {
      const std::uint32_t own = labels[piece[0]];
      const bool idle = std::none_of(piece.begin(), piece.end(), [&](auto v) { return motion.largest[v] > still; });
      if (own == nowhere || (piece.size() >= smallest_piece && !idle)) continue;
      std::map<std::uint32_t, std::size_t> touched;
      for (const std::uint32_t v : piece)
        for (const SurfaceGraph::Edge& edge : graph.edges(v))
          if (labels[edge.vertex] != nowhere && labels[edge.vertex] != own) ++touched[labels[edge.vertex]];
      if (touched.empty() && !idle) continue;
      const auto most = std::max_element(touched.begin(), touched.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      for (const std::uint32_t v : piece) labels[v] = touched.empty() ? nowhere : most->first;
      changed = true;
      break;  // the pieces are others now
    }
  }
}

// Numbers the regions that are left from 0 without gaps; gives their number.
std::uint32_t renumber(std::vector<std::uint32_t>& labels) {
  std::map<std::uint32_t, std::uint32_t> numbers;
  for (const std::uint32_t label : labels)
    if (label != nowhere) numbers.emplace(label, 0);
  std::uint32_t count = 0;
  for (auto& [label, number] : numbers) number = count++;
  for (std::uint32_t& label : labels)
    if (label != nowhere) label = numbers.at(label);
  return count;
}

// Shares of every vertex in the region of each label: 1 inside, 0 outside, and a smooth step across a band around the
// border, along the surface.
std::vector<std::vector<float>> blend(const SurfaceGraph& graph, const std::vector<std::uint32_t>& labels,
                                      std::uint32_t count, double band) {
  std::vector<char> moved(labels.size());
  for (std::size_t v = 0; v < labels.size(); ++v) moved[v] = labels[v] != nowhere;
  const double longest = band / band_edges;
  std::vector<std::vector<float>> shares(count, std::vector<float>(labels.size(), 0));
  for (std::uint32_t region = 0; region < count; ++region) {
    std::vector<double> distance(labels.size(), INFINITY);
    for (std::uint32_t v = 0; v < labels.size(); ++v) {
      if (!moved[v]) continue;
      for (const SurfaceGraph::Edge& edge : graph.edges(v))
        if (moved[edge.vertex] && (labels[v] == region) != (labels[edge.vertex] == region))
          distance[v] = std::min(distance[v], std::min<double>(edge.length, longest) / 2);
    }
    if (band > 0) graph.spread(distance, moved, longest, band / 2);
    for (std::size_t v = 0; v < labels.size(); ++v) {
      if (!moved[v]) continue;
      const bool inside = labels[v] == region;
      shares[region][v] = inside;
      if (band <= 0 || distance[v] >= band / 2) continue;
      const double t = 0.5 + (inside ? distance[v] : -distance[v]) / band;
      shares[region][v] = static_cast<float>(t * t * (3 - 2 * t));
    }
  }
  for (std::size_t v = 0; v < labels.size(); ++v) {
    float sum = 0;
    for (const std::vector<float>& share : shares) sum += share[v];
    for (std::vector<float>& share : shares)
      if (share[v] > 0) share[v] /= sum;
  }
  return shares;
}

FaceRegion describe(const RigSchema& schema, const Motion& motion, const std::vector<float>& shares, double still) {
  FaceRegion region;
  for (std::uint32_t v = 0; v < shares.size(); ++v) {
    if (shares[v] <= 0) continue;
    region.vertices.push_back(v);
    region.weights.push_back(shares[v]);
    region.energy += shares[v] * motion.energy[v];
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
    if (largest > still) region.controls.push_back(c);
    influence[schema.controls[c].group] += squares;
  }
  region.name = std::max_element(influence.begin(), influence.end(), [](const auto& a, const auto& b) {
                  return a.second < b.second;
                })->first;
  return region;
}

// "mouth", "mouth 2", "mouth 3".
void number_names(std::vector<FaceRegion>& regions) {
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
  if (!(options.overlap >= 0) || !(options.still > 0))
    fail(Status::invalid_argument, "an overlap of %g and a stillness of %g make no regions", options.overlap,
         options.still);
  const Motion motion = look_at(rest, schema, residual_motion);
  std::vector<std::uint32_t> labels = cluster(rest, motion, options);
  const SurfaceGraph graph(rest, split_vertices(rest, motion));
  join_fragments(graph, motion, options.still, labels);
  const std::uint32_t count = renumber(labels);

  std::vector<FaceRegion> regions;
  double total = 0;
  for (const std::vector<float>& shares : blend(graph, labels, count, options.overlap * rest.diagonal())) {
    regions.push_back(describe(schema, motion, shares, options.still));
    total += regions.back().energy;
  }
  for (FaceRegion& region : regions) region.energy /= total;
  std::stable_sort(regions.begin(), regions.end(),
                   [](const FaceRegion& a, const FaceRegion& b) { return a.energy > b.energy; });
  number_names(regions);
  return regions;
}

}  // namespace fb::bake
