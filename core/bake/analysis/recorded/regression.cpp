#include "bake/analysis/recorded/recorded_poses.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bake/linalg/gemm.h"

namespace fb::bake {
namespace {

constexpr std::size_t tile_rows = 768;  // coordinates of a parallel task
constexpr double standard_errors = 4;

NormalEquations accumulate(const RecordedPoses& recorded, std::span<const Feature> features,
                           std::span<const std::uint32_t> carriers, const Parallel& parallel, Progress& progress) {
  const std::size_t size = recorded.poses->source().rest().points.size(), count = recorded.picked.size();
  const std::size_t columns = carriers.size();
  const auto n = static_cast<Eigen::Index>(columns);
  NormalEquations sums{Eigen::MatrixXd::Zero(n, n), std::vector<float>(columns * size), std::vector<double>(size)};
  std::vector<float> residuals, table, values(features.size());
  progress.begin(Phase::analysis, "fitting recorded poses", count);
  for (std::size_t first = 0; first < count; first += recorded_poses_in_memory) {
    const std::size_t poses = std::min(recorded_poses_in_memory, count - first);
    residuals.resize(poses * size);
    table.resize(poses * columns);  // column-major: columns x poses
    recorded.read(first, poses, residuals, parallel);
    for (std::size_t i = 0; i < poses; ++i) {
      evaluate_features(features, recorded.pose(first + i), recorded.rest, values);
      for (std::size_t k = 0; k < columns; ++k) table[i * columns + k] = values[carriers[k]];
    }
    const Eigen::Map<const Eigen::MatrixXf> block(table.data(), n, static_cast<Eigen::Index>(poses));
    sums.gram += (block * block.transpose()).cast<double>();
    parallel_for(parallel, (size + tile_rows - 1) / tile_rows, [&](std::size_t tile, std::size_t) {
      const std::size_t row = tile * tile_rows, rows = std::min(tile_rows, size - row);
      gemm(Op::plain, Op::transposed, rows, columns, poses, residuals.data() + row, size, table.data(), columns, 1,
           sums.products.data() + row, size);
      for (std::size_t i = 0; i < poses; ++i)
        for (std::size_t r = row; r < row + rows; ++r)
          sums.squares[r] += double(residuals[i * size + r]) * residuals[i * size + r];
    });
    progress.step(first + poses);
  }
  return sums;
}

// The solution for coordinates [row, row + rows), columns x rows, and the standard deviation of what it leaves
// unexplained of each.
struct TileSolution {
  Eigen::MatrixXd solved;
  std::vector<double> deviations;
};

TileSolution solve_tile(const NormalEquations& equations, const Eigen::LLT<Eigen::MatrixXd>& solver, double freedom,
                        std::size_t row, std::size_t rows) {
  const std::size_t size = equations.squares.size(), columns = equations.products.size() / size;
  Eigen::MatrixXd right(static_cast<Eigen::Index>(columns), static_cast<Eigen::Index>(rows));
  for (std::size_t k = 0; k < columns; ++k)
    for (std::size_t r = 0; r < rows; ++r)
      right(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(r)) = equations.products[k * size + row + r];
  TileSolution tile{solver.solve(right), {}};
  const Eigen::MatrixXd explained = equations.gram * tile.solved;
  for (std::size_t r = 0; r < rows; ++r) {
    const auto column = static_cast<Eigen::Index>(r);
    // |x - F s|^2 = |x|^2 - 2 s.F'x + s.F'F s
    const double unexplained = equations.squares[row + r] - 2 * tile.solved.col(column).dot(right.col(column)) +
                               tile.solved.col(column).dot(explained.col(column));
    tile.deviations.push_back(std::sqrt(std::max(0.0, unexplained) / freedom));
  }
  return tile;
}

// Adds to each shape those vertices from `row` on whose offset is more than `bounds` standard deviations.
void add_significant(const TileSolution& tile, std::span<const double> bounds, std::size_t row,
                     std::vector<SparseShape>& shapes) {
  for (std::size_t k = 0; k < shapes.size(); ++k)
    for (std::size_t r = 0; r + 2 < tile.deviations.size(); r += 3) {
      double moved = 0, error = 0;
      for (std::size_t axis = r; axis < r + 3; ++axis) {
        const double s = tile.solved(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(axis));
        moved += s * s;
        error += tile.deviations[axis] * tile.deviations[axis];
      }
      if (moved <= error / 3 * bounds[k] * bounds[k] || moved == 0) continue;
      shapes[k].vertices.push_back(static_cast<std::uint32_t>((row + r) / 3));
      for (std::size_t axis = r; axis < r + 3; ++axis)
        shapes[k].offsets.push_back(
            static_cast<float>(tile.solved(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(axis))));
    }
}

}  // namespace

void RecordedPoses::read(std::size_t first, std::size_t count, std::span<float> residuals,
                         const Parallel& parallel) const {
  const std::size_t size = residuals.size() / count;
  for (std::size_t i = 0; i < count;) {  // consecutive poses are read together
    std::size_t run = 1;
    while (i + run < count && picked[first + i + run] == picked[first + i] + run) ++run;
    poses->read_displacements(picked[first + i], run, residuals.subspan(i * size, run * size));
    i += run;
  }
  parallel_for(parallel, count, [&](std::size_t i, std::size_t) {
    base->add(pose(first + i), rest, 1, -1, residuals.subspan(i * size, size));
  });
}

Regression::Regression(const RecordedPoses& recorded, std::span<const Feature> features,
                       std::vector<std::uint32_t> carriers, std::vector<double> ridge, const Parallel& parallel,
                       Progress& progress)
    : carriers_(std::move(carriers)), ridge_(std::move(ridge)), poses_(recorded.picked.size()) {
  if (!carriers_.empty() && poses_ > 0) equations_ = accumulate(recorded, features, carriers_, parallel, progress);
}

std::vector<SparseShape> Regression::shapes(double strength, const Parallel& parallel) const {
  const std::size_t size = equations_.squares.size();
  const Eigen::Index n = equations_.gram.rows();
  const double mean = n > 0 ? equations_.gram.trace() / double(n) : 0;
  if (mean == 0) return {};
  Eigen::MatrixXd damped = equations_.gram;
  for (Eigen::Index k = 0; k < n; ++k) damped(k, k) += strength * ridge_[static_cast<std::size_t>(k)] * mean;
  const Eigen::LLT<Eigen::MatrixXd> solver(damped);
  const Eigen::MatrixXd inverse = solver.solve(Eigen::MatrixXd::Identity(n, n));
  // Numbers fitted to each coordinate: the trace of what takes the recorded values to the fitted ones.
  const double fitted = inverse.cwiseProduct(equations_.gram).sum();
  const double freedom = std::max(1.0, double(poses_) - fitted);
  std::vector<double> bounds;
  for (Eigen::Index k = 0; k < n; ++k) bounds.push_back(standard_errors * std::sqrt(inverse(k, k)));

  const std::size_t tiles = (size + tile_rows - 1) / tile_rows;
  std::vector<std::vector<SparseShape>> of_tile(tiles, std::vector<SparseShape>(carriers_.size()));
  parallel_for(parallel, tiles, [&](std::size_t tile, std::size_t) {
    const std::size_t row = tile * tile_rows, rows = std::min(tile_rows, size - row);
    add_significant(solve_tile(equations_, solver, freedom, row, rows), bounds, row, of_tile[tile]);
  });
  std::vector<SparseShape> shapes(carriers_.size());
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    shapes[k].feature = carriers_[k];
    for (const std::vector<SparseShape>& tile : of_tile) {
      shapes[k].vertices.insert(shapes[k].vertices.end(), tile[k].vertices.begin(), tile[k].vertices.end());
      shapes[k].offsets.insert(shapes[k].offsets.end(), tile[k].offsets.begin(), tile[k].offsets.end());
    }
  }
  return shapes;
}

}  // namespace fb::bake
