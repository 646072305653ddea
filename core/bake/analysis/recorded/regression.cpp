#include "bake/analysis/recorded/recorded_poses.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bake/linalg/gemm.h"

namespace fb::bake {
namespace {

constexpr std::size_t poses_in_memory = 128;
constexpr std::size_t tile_rows = 768;  // coordinates of a parallel task
constexpr double standard_errors = 4;

// The normal equations of a regression: columns are the carriers' values in all poses.
struct NormalEquations {
  Eigen::MatrixXd gram;         // columns x columns
  std::vector<float> products;  // column-major: coordinates x columns
  std::vector<double> squares;  // of each coordinate, summed over poses
};

NormalEquations accumulate(const RecordedPoses& recorded, std::span<const Feature> features,
                           std::span<const std::uint32_t> carriers, const Parallel& parallel, Progress& progress) {
  const std::size_t size = recorded.poses->source().rest().points.size(), count = recorded.picked.size();
  const std::size_t columns = carriers.size();
  const auto n = static_cast<Eigen::Index>(columns);
  NormalEquations sums{Eigen::MatrixXd::Zero(n, n), std::vector<float>(columns * size), std::vector<double>(size)};
  std::vector<float> residuals, table, values(features.size());
  progress.begin("fitting recorded poses", count);
  for (std::size_t first = 0; first < count; first += poses_in_memory) {
    const std::size_t poses = std::min(poses_in_memory, count - first);
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

// Replaces the products by the solution, coordinates x columns. Returns the standard deviation of what it leaves
// unexplained of each coordinate.
std::vector<float> solve(NormalEquations& equations, const Eigen::LLT<Eigen::MatrixXd>& solver, std::size_t poses,
                         const Parallel& parallel) {
  const std::size_t size = equations.squares.size(), columns = equations.products.size() / size;
  std::vector<float> deviations(size);
  parallel_for(parallel, (size + tile_rows - 1) / tile_rows, [&](std::size_t tile, std::size_t) {
    const std::size_t row = tile * tile_rows, rows = std::min(tile_rows, size - row);
    Eigen::MatrixXd right(static_cast<Eigen::Index>(columns), static_cast<Eigen::Index>(rows));
    for (std::size_t k = 0; k < columns; ++k)
      for (std::size_t r = 0; r < rows; ++r)
        right(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(r)) = equations.products[k * size + row + r];
    const Eigen::MatrixXd solved = solver.solve(right);
    const Eigen::MatrixXd explained = equations.gram * solved;
    const double freedom = std::max(1.0, double(poses) - double(columns));
    for (std::size_t r = 0; r < rows; ++r) {
      const auto column = static_cast<Eigen::Index>(r);
      // |x - F s|^2 = |x|^2 - 2 s.F'x + s.F'F s
      const double unexplained = equations.squares[row + r] - 2 * solved.col(column).dot(right.col(column)) +
                                 solved.col(column).dot(explained.col(column));
      deviations[row + r] = static_cast<float>(std::sqrt(std::max(0.0, unexplained) / freedom));
      for (std::size_t k = 0; k < columns; ++k)
        equations.products[k * size + row + r] = static_cast<float>(solved(static_cast<Eigen::Index>(k), column));
    }
  });
  return deviations;
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

std::vector<SparseShape> regress(const RecordedPoses& recorded, std::span<const Feature> features,
                                 std::span<const std::uint32_t> carriers, std::span<const double> ridge,
                                 const Parallel& parallel, Progress& progress) {
  const std::size_t size = recorded.poses->source().rest().points.size(), count = recorded.picked.size();
  const std::size_t columns = carriers.size();
  if (columns == 0 || count == 0) return {};
  const auto n = static_cast<Eigen::Index>(columns);
  NormalEquations equations = accumulate(recorded, features, carriers, parallel, progress);
  const double mean = equations.gram.trace() / double(columns);
  if (mean == 0) return {};
  Eigen::MatrixXd damped = equations.gram;
  for (Eigen::Index k = 0; k < n; ++k) damped(k, k) += ridge[static_cast<std::size_t>(k)] * mean;
  const Eigen::LLT<Eigen::MatrixXd> solver(damped);
  const Eigen::VectorXd variances = solver.solve(Eigen::MatrixXd::Identity(n, n)).diagonal();
  const std::vector<float> deviations = solve(equations, solver, count, parallel);
  std::vector<SparseShape> shapes(columns);
  parallel_for(parallel, columns, [&](std::size_t k, std::size_t) {
    shapes[k].feature = carriers[k];
    const double bound = standard_errors * std::sqrt(variances[static_cast<Eigen::Index>(k)]);
    for (std::uint32_t v = 0; v < size / 3; ++v) {
      const float* s = equations.products.data() + k * size + 3 * v;
      const float* e = deviations.data() + 3 * v;
      const double moved = double(s[0]) * s[0] + double(s[1]) * s[1] + double(s[2]) * s[2];
      const double error = (double(e[0]) * e[0] + double(e[1]) * e[1] + double(e[2]) * e[2]) / 3 * bound * bound;
      if (moved <= error || moved == 0) continue;
      shapes[k].vertices.push_back(v);
      shapes[k].offsets.insert(shapes[k].offsets.end(), s, s + 3);
    }
  });
  return shapes;
}

}  // namespace fb::bake
