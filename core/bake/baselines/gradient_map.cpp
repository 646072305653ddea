#include "bake/baselines/gradient_map.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

#include "base/status.h"

namespace fb::bake {
namespace {

// Triangles with less area than this times their longest edge squared are skipped: their gradients are ill-conditioned.
constexpr double min_relative_area = 1e-5;

struct Triangle {
  std::array<std::uint32_t, 3> corners;
  std::array<double, 3> cotangents;  // of the angle at each corner
  double area;
};

std::vector<Triangle> gradient_triangles(const Mesh& rest) {
  std::vector<Triangle> triangles;
  const std::vector<std::uint32_t> corners = rest.triangles();
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    Triangle triangle{{corners[t], corners[t + 1], corners[t + 2]}, {}, 0};
    std::array<Eigen::Vector3d, 3> points;
    for (int i = 0; i < 3; ++i)
      points[i] = Eigen::Map<const Eigen::Vector3f>(rest.points.data() + 3 * triangle.corners[i]).cast<double>();
    const double twice = (points[1] - points[0]).cross(points[2] - points[0]).norm();
    double longest = 0;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d a = points[(i + 1) % 3] - points[i], b = points[(i + 2) % 3] - points[i];
      longest = std::max(longest, a.squaredNorm());
      triangle.cotangents[i] = a.dot(b) / twice;
    }
    triangle.area = twice / 2;
    if (triangle.area > min_relative_area * longest) triangles.push_back(triangle);
  }
  return triangles;
}

// The connected component of every vertex, by union-find; numbered in the order of their first vertices.
std::vector<std::uint32_t> components_of(std::size_t vertices, const std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> root(vertices);
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const Triangle& triangle : triangles)
    for (int i = 1; i < 3; ++i) {
      const std::uint32_t a = find(triangle.corners[0]), b = find(triangle.corners[i]);
      root[std::max(a, b)] = std::min(a, b);
    }
  std::vector<std::uint32_t> number(vertices), component(vertices);
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const std::uint32_t first = find(v);
    if (first == v) number[v] = count++;
    component[v] = number[first];
  }
  return component;
}

}  // namespace

GradientMap::GradientMap(const Mesh& rest) : vertices_(rest.vertex_count()), area_share_(vertices_, 0.0) {
  const std::vector<Triangle> triangles = gradient_triangles(rest);
  component_ = components_of(vertices_, triangles);
  double surface = 0;
  for (const Triangle& triangle : triangles) {
    surface += triangle.area;
    for (const std::uint32_t v : triangle.corners) area_share_[v] += triangle.area / 3;
  }
  const double diagonal = rest.diagonal();
  const double isolated = (surface > 0 ? surface : diagonal * diagonal) / static_cast<double>(vertices_);
  std::vector<Eigen::Index> unknown(vertices_, -1);
  for (std::uint32_t v = 0; v < vertices_; ++v) {
    if (area_share_[v] == 0) area_share_[v] = isolated;  // no triangle
    if (component_[v] == pinned_.size()) {
      pinned_.push_back(v);
      weight_.push_back(0);
    } else {
      unknown[v] = static_cast<Eigen::Index>(free_.size());
      free_.push_back(v);
    }
    weight_[component_[v]] += area_share_[v];
  }
  for (std::uint32_t v = 0; v < vertices_; ++v) area_share_[v] /= weight_[component_[v]];
  for (double& weight : weight_) weight = std::sqrt(weight) / (translation_length * diagonal);
  if (free_.empty()) return;

  std::vector<Eigen::Triplet<double>> entries;
  for (const Triangle& triangle : triangles)
    for (int i = 0; i < 3; ++i) {  // the edge across corner i
      const Eigen::Index a = unknown[triangle.corners[(i + 1) % 3]], b = unknown[triangle.corners[(i + 2) % 3]];
      const double half = triangle.cotangents[i] / 2;
      if (a >= 0) entries.emplace_back(a, a, half);
      if (b >= 0) entries.emplace_back(b, b, half);
      if (a >= 0 && b >= 0) {
        entries.emplace_back(a, b, -half);
        entries.emplace_back(b, a, -half);
      }
    }
  const auto size = static_cast<Eigen::Index>(free_.size());
  Eigen::SparseMatrix<double> laplacian(size, size);
  laplacian.setFromTriplets(entries.begin(), entries.end());
  factor_.compute(laplacian);
  if (factor_.info() != Eigen::Success) fail(Status::bad_data, "the Laplacian of the rest mesh cannot be factored");
}

void GradientMap::to_gradients(std::span<const float> displacements, std::span<float> gradients) const {
  const std::size_t means_offset = 3 * free_.size();
  Eigen::MatrixX3d means = Eigen::MatrixX3d::Zero(pinned_.size(), 3), relative(free_.size(), 3);
  for (std::size_t v = 0; v < vertices_; ++v)
    for (int axis = 0; axis < 3; ++axis) means(component_[v], axis) += area_share_[v] * displacements[3 * v + axis];
  for (std::size_t i = 0; i < free_.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      relative(i, axis) =
          double(displacements[3 * free_[i] + axis]) - displacements[3 * pinned_[component_[free_[i]]] + axis];
  if (!free_.empty()) relative = (factor_.matrixU() * (factor_.permutationP() * relative).eval()).eval();
  for (std::size_t i = 0; i < free_.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) gradients[3 * i + axis] = static_cast<float>(relative(i, axis));
  for (std::size_t c = 0; c < pinned_.size(); ++c)
    for (int axis = 0; axis < 3; ++axis)
      gradients[means_offset + 3 * c + axis] = static_cast<float>(weight_[c] * means(c, axis));
}

void GradientMap::to_displacements(std::span<const float> gradients, std::span<float> displacements) const {
  const std::size_t means_offset = 3 * free_.size();
  Eigen::MatrixX3d shift(pinned_.size(), 3), relative(free_.size(), 3);
  for (std::size_t i = 0; i < free_.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) relative(i, axis) = gradients[3 * i + axis];
  if (!free_.empty()) relative = (factor_.permutationPinv() * factor_.matrixU().solve(relative).eval()).eval();
  for (std::size_t c = 0; c < pinned_.size(); ++c)
    for (int axis = 0; axis < 3; ++axis) shift(c, axis) = gradients[means_offset + 3 * c + axis] / weight_[c];
  for (std::size_t i = 0; i < free_.size(); ++i)  // corrects the mean, which pinning the vertex has changed
    shift.row(component_[free_[i]]) -= area_share_[free_[i]] * relative.row(i);
  for (std::size_t c = 0; c < pinned_.size(); ++c)
    for (int axis = 0; axis < 3; ++axis) displacements[3 * pinned_[c] + axis] = static_cast<float>(shift(c, axis));
  for (std::size_t i = 0; i < free_.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      displacements[3 * free_[i] + axis] = static_cast<float>(relative(i, axis) + shift(component_[free_[i]], axis));
}

void GradientRows::read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const {
  poses().read_displacements(first, count, values);
  const std::size_t width = rows();
  parallel_for(parallel, count, [&](std::size_t pose, std::size_t) {
    const std::span<float> row = values.subspan(pose * width, width);
    map_->to_gradients(std::vector<float>(row.begin(), row.end()), row);
  });
}

}  // namespace fb::bake
