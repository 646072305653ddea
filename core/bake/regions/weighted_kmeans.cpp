#include "bake/regions/weighted_kmeans.h"

#include <algorithm>
#include <cmath>

#include "bake/linalg/gemm.h"
#include "base/random.h"

namespace fb::bake {
namespace {

struct Search {
  std::span<const float> points;
  std::size_t width;
  std::span<const double> weights;
  std::vector<float> squares;  // of each point's distance from the origin

  std::size_t count() const { return weights.size(); }
  const float* point(std::size_t i) const { return points.data() + i * width; }
};

float squared_norm(const float* values, std::size_t width) {
  double sum = 0;
  for (std::size_t k = 0; k < width; ++k) sum += double(values[k]) * values[k];
  return static_cast<float>(sum);
}

// Squared distances of all points to `count` centres: column of `count` numbers a point.
void distances(const Search& search, const float* centres, std::size_t count, std::vector<float>& out) {
  out.resize(search.count() * count);
  gemm(Op::transposed, Op::plain, count, search.count(), search.width, centres, search.width, search.points.data(),
       search.width, 0, out.data(), count);
  std::vector<float> squares(count);
  for (std::size_t k = 0; k < count; ++k) squares[k] = squared_norm(centres + k * search.width, search.width);
  for (std::size_t i = 0; i < search.count(); ++i)
    for (std::size_t k = 0; k < count; ++k) {
      float& d = out[i * count + k];
      d = std::max(0.0f, search.squares[i] + squares[k] - 2 * d);
    }
}

// A point drawn with probability in proportion to its chance; `count` of chances if all are 0.
std::size_t draw(const std::vector<double>& chances, Random& random) {
  double sum = 0;
  for (const double chance : chances) sum += chance;
  double left = random.uniform() * sum;
  std::size_t last = chances.size();
  for (std::size_t i = 0; i < chances.size(); ++i) {
    if (chances[i] <= 0) continue;
    last = i;
    if ((left -= chances[i]) < 0) break;
  }
  return last;
}

std::vector<float> starting_centres(const Search& search, std::size_t clusters, Random& random) {
  std::vector<float> centres, distance;
  std::vector<double> chances(search.weights.begin(), search.weights.end());
  std::vector<float> nearest(search.count(), INFINITY);
  while (centres.size() < clusters * search.width) {
    const std::size_t chosen = draw(chances, random);
    if (chosen == search.count()) break;  // every point lies on a centre already
    const float* point = search.point(chosen);
    centres.insert(centres.end(), point, point + search.width);
    distances(search, centres.data() + centres.size() - search.width, 1, distance);
    for (std::size_t i = 0; i < search.count(); ++i) {
      nearest[i] = std::min(nearest[i], distance[i]);
      chances[i] = search.weights[i] * nearest[i];
    }
    chances[chosen] = 0;
  }
  return centres;
}

struct Clustering {
  std::vector<float> centres;
  std::vector<std::uint32_t> labels;
  double cost = INFINITY;

  std::size_t size(const Search& search) const { return centres.size() / search.width; }
};

// Gives every point to its nearest centre; true if any changed.
bool assign(const Search& search, Clustering& state, std::vector<float>& distance) {
  const std::size_t clusters = state.size(search);
  distances(search, state.centres.data(), clusters, distance);
  bool changed = false;
  state.cost = 0;
  for (std::size_t i = 0; i < search.count(); ++i) {
    const float* d = distance.data() + i * clusters;
    const auto best = static_cast<std::uint32_t>(std::min_element(d, d + clusters) - d);
    changed |= state.labels[i] != best;
    state.labels[i] = best;
    state.cost += search.weights[i] * d[best];
  }
  return changed;
}

// Moves every centre to the mean of its points; one without weight stays where it is.
void update(const Search& search, Clustering& state) {
  const std::size_t clusters = state.size(search);
  std::vector<double> sums(state.centres.size(), 0), totals(clusters, 0);
  for (std::size_t i = 0; i < search.count(); ++i) {
    const float* point = search.point(i);
    double* sum = sums.data() + state.labels[i] * search.width;
    for (std::size_t k = 0; k < search.width; ++k) sum[k] += search.weights[i] * point[k];
    totals[state.labels[i]] += search.weights[i];
  }
  for (std::size_t c = 0; c < clusters; ++c)
    for (std::size_t k = 0; totals[c] > 0 && k < search.width; ++k)
      state.centres[c * search.width + k] = static_cast<float>(sums[c * search.width + k] / totals[c]);
}

void iterate(const Search& search, std::size_t steps, Clustering& state) {
  std::vector<float> distance;
  for (std::size_t step = 0; assign(search, state, distance) && step < steps; ++step) update(search, state);
}

// Takes away the smallest cluster until none is too small.
void dissolve(const Search& search, const KmeansOptions& options, Clustering& state) {
  for (;;) {
    std::vector<std::size_t> sizes(state.size(search), 0);
    for (const std::uint32_t label : state.labels) ++sizes[label];
    const auto least = std::min_element(sizes.begin(), sizes.end());
    if (sizes.size() == 1 || *least >= options.smallest) return;
    const auto first = state.centres.begin() + (least - sizes.begin()) * std::ptrdiff_t(search.width);
    state.centres.erase(first, first + std::ptrdiff_t(search.width));
    iterate(search, options.steps, state);
  }
}

}  // namespace

std::vector<std::uint32_t> weighted_kmeans(std::span<const float> points, std::size_t width,
                                           std::span<const double> weights, const KmeansOptions& options) {
  Search search{points, width, weights, std::vector<float>(weights.size())};
  for (std::size_t i = 0; i < search.count(); ++i) search.squares[i] = squared_norm(search.point(i), width);
  Clustering best;
  best.labels.assign(search.count(), 0);
  for (std::size_t start = 0; start < options.restarts; ++start) {
    Random random(options.seed, start);
    Clustering state;
    state.labels.assign(search.count(), UINT32_MAX);
    state.centres = starting_centres(search, options.clusters, random);
    if (state.centres.empty()) break;  // nothing weighs anything
    iterate(search, options.steps, state);
    if (state.cost < best.cost) best = std::move(state);
  }
  if (!best.centres.empty()) dissolve(search, {options}, best);
  return best.labels;
}

}  // namespace fb::bake
