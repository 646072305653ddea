#include "bake/regions/weighted_kmeans.h"

#include <algorithm>
#include <cmath>

#include "bake/linalg/gemm.h"
#include "base/random_streams.h"

namespace fb::bake {
namespace {

struct WeightedPoints {
  std::span<const float> values;
  std::size_t width;
  std::span<const double> weights;
  std::vector<float> squared_norms;  // of the points

  std::size_t count() const { return weights.size(); }
  const float* point(std::size_t i) const { return values.data() + i * width; }
};

float squared_norm(const float* values, std::size_t width) {
  double sum = 0;
  for (std::size_t k = 0; k < width; ++k) sum += double(values[k]) * values[k];
  return static_cast<float>(sum);
}

// Squared distances of all points to `count` centres: `count` floats a point.
void squared_distances(const WeightedPoints& points, const float* centres, std::size_t count, std::vector<float>& out) {
  out.resize(points.count() * count);
  gemm(Op::transposed, Op::plain, count, points.count(), points.width, centres, points.width, points.values.data(),
       points.width, 0, out.data(), count);
  std::vector<float> squares(count);
  for (std::size_t k = 0; k < count; ++k) squares[k] = squared_norm(centres + k * points.width, points.width);
  for (std::size_t i = 0; i < points.count(); ++i)
    for (std::size_t k = 0; k < count; ++k) {
      float& d = out[i * count + k];
      d = std::max(0.0f, points.squared_norms[i] + squares[k] - 2 * d);
    }
}

// A random index with probability in proportion to its weight; weights.size() if all are 0.
std::size_t sample_index(const std::vector<double>& weights, Random& random) {
  double sum = 0;
  for (const double weight : weights) sum += weight;
  double remaining = random.uniform() * sum;
  std::size_t last = weights.size();
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] <= 0) continue;
    last = i;
    if ((remaining -= weights[i]) < 0) break;
  }
  return last;
}

// k-means++: each next centre is a point sampled by weight x squared distance to the nearest centre.
std::vector<float> initial_centres(const WeightedPoints& points, std::size_t clusters, Random& random) {
  std::vector<float> centres, distance;
  std::vector<double> probability(points.weights.begin(), points.weights.end());
  std::vector<float> nearest(points.count(), INFINITY);
  while (centres.size() < clusters * points.width) {
    const std::size_t chosen = sample_index(probability, random);
    if (chosen == points.count()) break;  // every point with weight is a centre
    const float* point = points.point(chosen);
    centres.insert(centres.end(), point, point + points.width);
    squared_distances(points, centres.data() + centres.size() - points.width, 1, distance);
    for (std::size_t i = 0; i < points.count(); ++i) {
      nearest[i] = std::min(nearest[i], distance[i]);
      probability[i] = points.weights[i] * nearest[i];
    }
    probability[chosen] = 0;
  }
  return centres;
}

struct Clustering {
  std::vector<float> centres;
  std::vector<std::uint32_t> labels;
  double cost = INFINITY;

  std::size_t size(const WeightedPoints& points) const { return centres.size() / points.width; }
};

// Assigns every point to its nearest centre; true if any label changed.
bool assign_points(const WeightedPoints& points, Clustering& clustering, std::vector<float>& distance) {
  const std::size_t clusters = clustering.size(points);
  squared_distances(points, clustering.centres.data(), clusters, distance);
  bool changed = false;
  clustering.cost = 0;
  for (std::size_t i = 0; i < points.count(); ++i) {
    const float* d = distance.data() + i * clusters;
    const auto best = static_cast<std::uint32_t>(std::min_element(d, d + clusters) - d);
    changed |= clustering.labels[i] != best;
    clustering.labels[i] = best;
    clustering.cost += points.weights[i] * d[best];
  }
  return changed;
}

// Moves every centre to the weighted mean of its points; centres without weight stay.
void update_centres(const WeightedPoints& points, Clustering& clustering) {
  const std::size_t clusters = clustering.size(points);
  std::vector<double> sums(clustering.centres.size(), 0), totals(clusters, 0);
  for (std::size_t i = 0; i < points.count(); ++i) {
    const float* point = points.point(i);
    double* sum = sums.data() + clustering.labels[i] * points.width;
    for (std::size_t k = 0; k < points.width; ++k) sum[k] += points.weights[i] * point[k];
    totals[clustering.labels[i]] += points.weights[i];
  }
  for (std::size_t c = 0; c < clusters; ++c)
    for (std::size_t k = 0; totals[c] > 0 && k < points.width; ++k)
      clustering.centres[c * points.width + k] = static_cast<float>(sums[c * points.width + k] / totals[c]);
}

void lloyd_iterations(const WeightedPoints& points, std::size_t max_iterations, Clustering& clustering) {
  std::vector<float> distance;
  for (std::size_t i = 0; assign_points(points, clustering, distance) && i < max_iterations; ++i)
    update_centres(points, clustering);
}

// Removes the smallest cluster until none is below min_cluster_size.
void remove_small_clusters(const WeightedPoints& points, const KmeansOptions& options, Clustering& clustering) {
  for (;;) {
    std::vector<std::size_t> sizes(clustering.size(points), 0);
    for (const std::uint32_t label : clustering.labels) ++sizes[label];
    const auto smallest = std::min_element(sizes.begin(), sizes.end());
    if (sizes.size() == 1 || *smallest >= options.min_cluster_size) return;
    const auto first = clustering.centres.begin() + (smallest - sizes.begin()) * std::ptrdiff_t(points.width);
    clustering.centres.erase(first, first + std::ptrdiff_t(points.width));
    lloyd_iterations(points, options.max_iterations, clustering);
  }
}

}  // namespace

std::vector<std::uint32_t> weighted_kmeans(std::span<const float> points, std::size_t width,
                                           std::span<const double> weights, const KmeansOptions& options) {
  WeightedPoints input{points, width, weights, std::vector<float>(weights.size())};
  for (std::size_t i = 0; i < input.count(); ++i) input.squared_norms[i] = squared_norm(input.point(i), width);
  Clustering best;
  best.labels.assign(input.count(), 0);
  for (std::size_t start = 0; start < options.restarts; ++start) {
    Random random = open_stream(options.seed, Stream::cluster_starts, start);
    Clustering clustering;
    clustering.labels.assign(input.count(), UINT32_MAX);
    clustering.centres = initial_centres(input, options.clusters, random);
    if (clustering.centres.empty()) break;  // all weights are 0
    lloyd_iterations(input, options.max_iterations, clustering);
    if (clustering.cost < best.cost) best = std::move(clustering);
  }
  if (!best.centres.empty()) remove_small_clusters(input, options, best);
  return best.labels;
}

}  // namespace fb::bake
