#include "bake/analysis/recorded/regression.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bake/linalg/gemm.h"

namespace fb::bake {
namespace {

constexpr std::size_t block_poses = 128;
constexpr std::size_t tile_rows = 768;  // coordinates a task of the product takes
constexpr double standard_errors = 4;

}  // namespace

void RecordedPoses::read(std::size_t first, std::size_t count, std::span<float> left, const Parallel& parallel) const {
  const std::size_t size = left.size() / count;
  for (std::size_t i = 0; i < count;) {  // runs of consecutive poses are read together
    std::size_t run = 1;
    while (i + run < count && picked[first + i + run] == picked[first + i] + run) ++run;
    poses->read_displacements(picked[first + i], run, left.subspan(i * size, run * size));
    i += run;
  }
  parallel_for(parallel, count, [&](std::size_t i, std::size_t) {
    base->add(pose(first + i), rest, 1, -1, left.subspan(i * size, size));
  });
}

std::vector<SparseShape> regress(const RecordedPoses& recorded, std::span<const Feature> features,
                                 std::span<const std::uint32_t> carriers, std::span<const double> ridge,
                                 const Parallel& parallel, Progress& progress) {
  const std::size_t size = recorded.poses->source().rest().points.size(), count = recorded.picked.size();
  const std::size_t columns = carriers.size();
  if (columns == 0 || count == 0) return {};
  const auto n = static_cast<Eigen::Index>(columns);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(n, n);
  std::vector<float> products(columns * size);  // column-major: size x columns
  std::vector<double> squares(size);
  std::vector<float> left, table, values(features.size());
  progress.begin("fitting recorded poses", count);
  for (std::size_t first = 0; first < count; first += block_poses) {
    const std::size_t poses = std::min(block_poses, count - first);
    left.resize(poses * size);
    table.resize(poses * columns);  // column-major: columns x poses
    recorded.read(first, poses, left, parallel);
    for (std::size_t i = 0; i < poses; ++i) {
      evaluate_features(features, recorded.pose(first + i), recorded.rest, values);
      for (std::size_t k = 0; k < columns; ++k) table[i * columns + k] = values[carriers[k]];
    }
    const Eigen::Map<const Eigen::MatrixXf> block(table.data(), n, static_cast<Eigen::Index>(poses));
    gram += (block * block.transpose()).cast<double>();
    parallel_for(parallel, (size + tile_rows - 1) / tile_rows, [&](std::size_t tile, std::size_t) {
      const std::size_t row = tile * tile_rows, rows = std::min(tile_rows, size - row);
      gemm(Op::plain, Op::transposed, rows, columns, poses, left.data() + row, size, table.data(), columns, 1,
           products.data() + row, size);
      for (std::size_t i = 0; i < poses; ++i)
        for (std::size_t r = row; r < row + rows; ++r) squares[r] += double(left[i * size + r]) * left[i * size + r];
    });
    progress.step(first + poses);
  }
  const double mean = gram.trace() / double(columns);
  if (mean == 0) return {};
  Eigen::MatrixXd damped = gram;
  for (Eigen::Index k = 0; k < n; ++k) damped(k, k) += ridge[static_cast<std::size_t>(k)] * mean;
  const Eigen::LLT<Eigen::MatrixXd> solver(damped);
  const Eigen::VectorXd spread = solver.solve(Eigen::MatrixXd::Identity(n, n)).diagonal();
  std::vector<SparseShape> shapes(columns);
  for (std::size_t k = 0; k < columns; ++k) shapes[k].feature = carriers[k];
  const std::size_t tiles = (size + tile_rows - 1) / tile_rows;
  std::vector<float> noise(size);
  parallel_for(parallel, tiles, [&](std::size_t tile, std::size_t) {
    const std::size_t row = tile * tile_rows, rows = std::min(tile_rows, size - row);
    Eigen::MatrixXd right(n, static_cast<Eigen::Index>(rows));
    for (std::size_t k = 0; k < columns; ++k)
      for (std::size_t r = 0; r < rows; ++r)
        right(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(r)) = products[k * size + row + r];
    const Eigen::MatrixXd solved = solver.solve(right);
    const Eigen::MatrixXd explained = gram * solved;
    const double freedom = std::max(1.0, double(count) - double(columns));
    for (std::size_t r = 0; r < rows; ++r) {
      const auto column = static_cast<Eigen::Index>(r);
      // |x - F s|^2 = |x|^2 - 2 s.F'x + s.F'F s
      const double unexplained = squares[row + r] - 2 * solved.col(column).dot(right.col(column)) +
                                 solved.col(column).dot(explained.col(column));
      noise[row + r] = static_cast<float>(std::sqrt(std::max(0.0, unexplained) / freedom));
      for (std::size_t k = 0; k < columns; ++k)
        products[k * size + row + r] = static_cast<float>(solved(static_cast<Eigen::Index>(k), column));
    }
  });
  parallel_for(parallel, columns, [&](std::size_t k, std::size_t) {
    const double bound = standard_errors * std::sqrt(spread[static_cast<Eigen::Index>(k)]);
    for (std::uint32_t v = 0; v < size / 3; ++v) {
      const float* s = products.data() + k * size + 3 * v;
      const float* e = noise.data() + 3 * v;
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
