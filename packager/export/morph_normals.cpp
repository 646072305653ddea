#include "export/morph_normals.h"

#include <Eigen/Dense>
#include <algorithm>
#include <map>

#include "base/surface.h"

namespace fb::tool {
namespace {

using Grid = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// For each vertex, the targets that move it or one of its neighbours; vertices with the same ones together.
std::map<std::vector<std::uint32_t>, std::vector<std::size_t>> vertices_by_targets(
    const MorphTargets& morph, std::span<const std::uint32_t> triangles, std::size_t vertices) {
  std::vector<std::vector<std::uint32_t>> targets(vertices);
  for (std::size_t t = 0; t < morph.count; ++t) {
    const std::span<const float> moves = morph.target(t);
    const auto moved = [&](std::size_t v) {
      return moves[3 * v] != 0 || moves[3 * v + 1] != 0 || moves[3 * v + 2] != 0;
    };
    const auto add = [&](std::size_t v) {
      if (targets[v].empty() || targets[v].back() != t) targets[v].push_back(static_cast<std::uint32_t>(t));
    };
    for (std::size_t c = 0; c < triangles.size(); c += 3)
      if (moved(triangles[c]) || moved(triangles[c + 1]) || moved(triangles[c + 2]))
        for (std::size_t k = 0; k < 3; ++k) add(triangles[c + k]);
  }
  std::map<std::vector<std::uint32_t>, std::vector<std::size_t>> groups;
  for (std::size_t v = 0; v < vertices; ++v)
    if (!targets[v].empty()) groups[targets[v]].push_back(v);
  return groups;
}

// Weights of the frames, transposed, times the changes of their normals: targets x 3 x vertices.
Grid weighted_changes(const MorphTargets& morph, const MeshView& mesh, const FrameReader& read, std::size_t frames,
                      const Parallel& parallel) {
  const std::vector<std::uint32_t> triangles = mesh.triangles();
  const std::vector<float> rest = unit_normals(triangles, mesh.points);
  const auto size = static_cast<Eigen::Index>(rest.size()), targets = static_cast<Eigen::Index>(morph.count);
  Grid sums = Grid::Zero(targets, size);
  for_frame_blocks(read, frames, [&](std::size_t first, std::size_t count, std::span<const float> moves) {
    Grid changes(static_cast<Eigen::Index>(count), size);
    parallel_for(parallel, count, [&](std::size_t f, std::size_t) {
      std::vector<float> points(mesh.points.begin(), mesh.points.end());
      for (std::size_t i = 0; i < points.size(); ++i) points[i] += moves[f * points.size() + i];
      const std::vector<float> normals = unit_normals(triangles, points);
      for (std::size_t i = 0; i < normals.size(); ++i)
        changes(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(i)) = normals[i] - rest[i];
    });
    const Eigen::Map<const Grid> weights(&morph.weights[first * morph.count], changes.rows(), targets);
    constexpr Eigen::Index task_columns = 1024;
    parallel_for(parallel, static_cast<std::size_t>((size + task_columns - 1) / task_columns),
                 [&](std::size_t task, std::size_t) {
                   const Eigen::Index begin = static_cast<Eigen::Index>(task) * task_columns,
                                      some = std::min(task_columns, size - begin);
                   sums.middleCols(begin, some).noalias() += weights.transpose() * changes.middleCols(begin, some);
                 });
  });
  return sums;
}

// The pseudo-inverse of the weights' products, scaled to a diagonal of ones, for some targets.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& products, const std::vector<std::uint32_t>& chosen) {
  const auto count = static_cast<Eigen::Index>(chosen.size());
  Eigen::VectorXd scales(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double square = products(chosen[static_cast<std::size_t>(i)], chosen[static_cast<std::size_t>(i)]);
    scales(i) = square > 0 ? 1 / std::sqrt(square) : 0;
  }
  Eigen::MatrixXd scaled(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index k = 0; k < count; ++k)
      scaled(i, k) =
          scales(i) * scales(k) * products(chosen[static_cast<std::size_t>(i)], chosen[static_cast<std::size_t>(k)]);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(scaled);
  Eigen::VectorXd inverse = axes.eigenvalues();
  const double least = 1e-8 * inverse.maxCoeff();  // weights are floats
  for (double& value : inverse) value = value > least ? 1 / value : 0;
  return scales.asDiagonal() * axes.eigenvectors() * inverse.asDiagonal() * axes.eigenvectors().transpose() *
         scales.asDiagonal();
}

}  // namespace

std::vector<float> unit_normals(std::span<const std::uint32_t> triangles, std::span<const float> points) {
  std::vector<float> normals;
  normals.reserve(points.size());
  for (Vector3 n : vertex_normals(triangles, points)) {
    if (!(length(n) > 0)) n = {0, 0, 1};
    normals.insert(normals.end(), {n.x, n.y, n.z});
  }
  return normals;
}

void set_normals(MorphTargets& morph, const MeshView& mesh) {
  const std::vector<std::uint32_t> triangles = mesh.triangles();
  const std::vector<float> rest = unit_normals(triangles, mesh.points);
  morph.normals.clear();
  for (std::size_t t = 0; t < morph.count; ++t) {
    std::vector<float> points(mesh.points.begin(), mesh.points.end());
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += morph.target(t)[i];
    const std::vector<float> normals = unit_normals(triangles, points);
    for (std::size_t i = 0; i < normals.size(); ++i) morph.normals.push_back(normals[i] - rest[i]);
  }
}

void fit_normals(MorphTargets& morph, const MeshView& mesh, const FrameReader& read, std::size_t frames,
                 const Parallel& parallel) {
  morph.normals.assign(morph.displacements.size(), 0);
  if (morph.count == 0) return;
  const Grid sums = weighted_changes(morph, mesh, read, frames, parallel);
  const Eigen::MatrixXd weights = Eigen::Map<const Grid>(morph.weights.data(), static_cast<Eigen::Index>(frames),
                                                         static_cast<Eigen::Index>(morph.count))
                                      .cast<double>();
  const Eigen::MatrixXd products = weights.transpose() * weights;
  const std::size_t size = mesh.points.size();
  for (const auto& [targets, vertices] : vertices_by_targets(morph, mesh.triangles(), mesh.vertex_count())) {
    const Eigen::MatrixXd inverse = inverse_of(products, targets);
    Eigen::MatrixXd right(inverse.rows(), 3 * static_cast<Eigen::Index>(vertices.size()));
    for (std::size_t i = 0; i < targets.size(); ++i)
      for (std::size_t c = 0; c < 3 * vertices.size(); ++c)
        right(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) =
            sums(targets[i], static_cast<Eigen::Index>(3 * vertices[c / 3] + c % 3));
    const Eigen::MatrixXd found = inverse * right;
    for (std::size_t i = 0; i < targets.size(); ++i)
      for (std::size_t c = 0; c < 3 * vertices.size(); ++c)
        morph.normals[targets[i] * size + 3 * vertices[c / 3] + c % 3] =
            static_cast<float>(found(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)));
  }
}

}  // namespace fb::tool
