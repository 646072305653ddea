#include "dense/dense_mesh.h"

#include <algorithm>
#include <map>
#include <utility>

namespace rigs::dense {
namespace {

using Sum = std::vector<std::pair<std::uint32_t, double>>;  // coarse vertices with weights, by ascending vertex

void add(Sum& to, const Sum& from, double factor) {
  for (const auto& [vertex, weight] : from) {
    const auto at = std::lower_bound(to.begin(), to.end(), std::pair(vertex, -1e9));
    if (at != to.end() && at->first == vertex)
      at->second += factor * weight;
    else
      to.insert(at, {vertex, factor * weight});
  }
}

// The vertices of the quads cut up, each a sum of corners of its quad or edge.
class Cutter {
 public:
  Cutter(std::uint32_t vertices, std::uint32_t divisions) : n_(divisions) {
    for (std::uint32_t v = 0; v < vertices; ++v) sums_.push_back({{v, 1.0}});
  }

  void cut(const std::array<std::uint32_t, 4>& quad, Quads& quads) {
    std::vector<std::uint32_t> grid((n_ + 1) * (n_ + 1));
    for (std::uint32_t j = 0; j <= n_; ++j)
      for (std::uint32_t i = 0; i <= n_; ++i) grid[j * (n_ + 1) + i] = vertex_at(quad, i, j);
    for (std::uint32_t j = 0; j < n_; ++j)
      for (std::uint32_t i = 0; i < n_; ++i) {
        const std::uint32_t* const v = &grid[j * (n_ + 1) + i];
        quads.push_back({v[0], v[1], v[n_ + 2], v[n_ + 1]});
      }
  }

  std::vector<Sum>& sums() { return sums_; }

 private:
  std::uint32_t vertex_at(const std::array<std::uint32_t, 4>& q, std::uint32_t i, std::uint32_t j) {
    if (j == 0) return on_edge(q[0], q[1], i);
    if (j == n_) return on_edge(q[3], q[2], i);
    if (i == 0) return on_edge(q[0], q[3], j);
    if (i == n_) return on_edge(q[1], q[2], j);
    const double s = double(i) / n_, t = double(j) / n_;
    Sum sum;
    add(sum, {{q[0], (1 - s) * (1 - t)}}, 1);
    add(sum, {{q[1], s * (1 - t)}}, 1);
    add(sum, {{q[2], s * t}}, 1);
    add(sum, {{q[3], (1 - s) * t}}, 1);
    sums_.push_back(std::move(sum));
    return static_cast<std::uint32_t>(sums_.size() - 1);
  }

  std::uint32_t on_edge(std::uint32_t a, std::uint32_t b, std::uint32_t i) {
    if (i == 0) return a;
    if (i == n_) return b;
    if (a > b) std::swap(a, b), i = n_ - i;
    const auto [found, fresh] = edges_.try_emplace({a, b, i}, static_cast<std::uint32_t>(sums_.size()));
    if (fresh) {
      const double t = double(i) / n_;
      sums_.push_back({{a, 1 - t}, {b, t}});
    }
    return found->second;
  }

  std::uint32_t n_;
  std::vector<Sum> sums_;
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> edges_;  // by two vertices and the step between them
};

// Of every vertex, the mean of the means of its quads; those of the border stay.
std::vector<Sum> averaged(const std::vector<Sum>& sums, const Quads& quads) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::vector<std::uint32_t> around(sums.size());
  for (const auto& quad : quads)
    for (std::size_t k = 0; k < 4; ++k) {
      ++edges[std::minmax(quad[k], quad[(k + 1) % 4])];
      ++around[quad[k]];
    }
  std::vector<char> border(sums.size());
  for (const auto& [edge, count] : edges)
    if (count == 1) border[edge.first] = border[edge.second] = 1;
  std::vector<Sum> means(sums.size());
  for (const auto& quad : quads)
    for (const std::uint32_t to : quad)
      for (const std::uint32_t from : quad)
        if (!border[to]) add(means[to], sums[from], 0.25 / around[to]);
  for (std::size_t v = 0; v < sums.size(); ++v)
    if (border[v] || around[v] == 0) means[v] = sums[v];
  return means;
}

}  // namespace

DenseMesh::DenseMesh(std::uint32_t coarse_vertices, const Quads& coarse, std::uint32_t divisions) : first_{0} {
  Cutter cutter(coarse_vertices, divisions);
  for (const auto& quad : coarse) cutter.cut(quad, quads_);
  if (divisions > 1) cutter.sums() = averaged(cutter.sums(), quads_);
  for (const Sum& sum : cutter.sums()) {
    for (const auto& [vertex, weight] : sum) {
      corners_.push_back(vertex);
      weights_.push_back(static_cast<float>(weight));
    }
    first_.push_back(static_cast<std::uint32_t>(corners_.size()));
  }
}

void DenseMesh::pose(const float* coarse, float* fine) const {
  for (std::uint32_t v = 0; v < vertices(); ++v, fine += 3) {
    float x = 0, y = 0, z = 0;
    for (std::uint32_t k = first_[v]; k < first_[v + 1]; ++k) {
      const float* const from = coarse + 3 * std::size_t(corners_[k]);
      x += weights_[k] * from[0];
      y += weights_[k] * from[1];
      z += weights_[k] * from[2];
    }
    fine[0] = x, fine[1] = y, fine[2] = z;
  }
}

}  // namespace rigs::dense
