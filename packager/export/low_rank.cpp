#include "export/low_rank.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace fb::tool {
namespace {

using Matrix = Eigen::MatrixXf;
using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t block_frames = 64;
constexpr Eigen::Index task_frames = 16;

// Frames = weights (frames x components) times directions (3 x vertices x components) transposed. Directions are
// orthonormal, and ordered by how much they move.
struct Components {
  Matrix weights, directions;
};

Eigen::Index index(std::size_t number) {
  return static_cast<Eigen::Index>(number);
}

// Loop over tasks of some rows each.
void for_rows(const Parallel& parallel, Eigen::Index rows,
              const std::function<void(Eigen::Index, Eigen::Index)>& body) {
  const Eigen::Index tasks = (rows + task_frames - 1) / task_frames;
  parallel_for(parallel, static_cast<std::size_t>(tasks), [&](std::size_t task, std::size_t) {
    const Eigen::Index first = index(task) * task_frames;
    body(first, std::min(task_frames, rows - first));
  });
}

// An orthonormal basis of the space that the targets span, and the frames in it; then turned to the principal axes.
Components components_of(const MorphTargets& spanning, const FrameReader& read, std::size_t frames,
                         const Parallel& parallel) {
  const Eigen::Index count = index(spanning.count), size = index(spanning.displacements.size()) / count;
  const Eigen::HouseholderQR<Matrix> qr(Eigen::Map<const Matrix>(spanning.displacements.data(), size, count));
  const Matrix basis = qr.householderQ() * Matrix::Identity(size, std::min(size, count));
  // The frames are many: what they take is held once, in single precision.
  Matrix coordinates(index(frames), basis.cols());
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(basis.cols(), basis.cols());
  for_frame_blocks(read, frames, [&](std::size_t first, std::size_t block, std::span<const float> moves) {
    const Eigen::Map<const Rows> rows(moves.data(), index(block), size);
    for_rows(parallel, index(block), [&](Eigen::Index row, Eigen::Index some) {
      coordinates.middleRows(index(first) + row, some).noalias() = rows.middleRows(row, some) * basis;
    });
    const Eigen::MatrixXd precise = coordinates.middleRows(index(first), index(block)).cast<double>();
    squares.noalias() += precise.transpose() * precise;
  });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(squares);  // ascending
  const Eigen::MatrixXd turn = axes.eigenvectors().rowwise().reverse();
  for_rows(parallel, index(frames), [&](Eigen::Index first, Eigen::Index some) {
    auto rows = coordinates.middleRows(first, some);
    rows = (rows.cast<double>().eval() * turn).cast<float>().eval();
  });
  return {std::move(coordinates), basis * turn.cast<float>()};
}

// For each of these frames, the largest distance that a vertex lies off if only the first `kept` components are.
std::vector<float> remainders(const Components& components, const std::vector<Eigen::Index>& frames, Eigen::Index kept,
                              const Parallel& parallel) {
  const Eigen::Index left = components.weights.cols() - kept;
  std::vector<float> distances(frames.size(), 0);
  if (left == 0) return distances;
  for_rows(parallel, index(frames.size()), [&](Eigen::Index first, Eigen::Index some) {
    Matrix weights(left, some);
    for (Eigen::Index f = 0; f < some; ++f)
      weights.col(f) = components.weights.row(frames[static_cast<std::size_t>(first + f)]).tail(left);
    const Matrix moves = components.directions.rightCols(left) * weights;
    for (Eigen::Index f = 0; f < some; ++f) {
      const Eigen::Map<const Matrix> vertices(moves.col(f).data(), 3, moves.rows() / 3);
      distances[static_cast<std::size_t>(first + f)] = std::sqrt(vertices.colwise().squaredNorm().maxCoeff());
    }
  });
  return distances;
}

bool all_within(const std::vector<float>& distances, double tolerance) {
  return std::all_of(distances.begin(), distances.end(), [&](float distance) { return distance <= tolerance; });
}

// The fewest components that are enough for all frames. Bisection looks at some frames; those that its result is not
// enough for join them, until there are none.
Eigen::Index enough_components(const Components& components, double tolerance, const Parallel& parallel) {
  std::vector<Eigen::Index> all(static_cast<std::size_t>(components.weights.rows())), some;
  std::iota(all.begin(), all.end(), 0);
  const std::size_t step = (all.size() + block_frames - 1) / block_frames;
  for (std::size_t f = 0; f < all.size(); f += step) some.push_back(all[f]);
  for (Eigen::Index few = -1;;) {  // never enough
    Eigen::Index enough = components.weights.cols();
    while (enough - few > 1) {
      const Eigen::Index half = few + (enough - few) / 2;
      (all_within(remainders(components, some, half, parallel), tolerance) ? enough : few) = half;
    }
    const std::vector<float> distances = remainders(components, all, enough, parallel);
    if (all_within(distances, tolerance)) return enough;
    some.clear();
    for (std::size_t f = 0; f < all.size(); ++f)
      if (distances[f] > tolerance) some.push_back(all[f]);
    few = enough;
  }
}

// Targets are scaled so that the largest weight of each is 1.
MorphTargets targets_from(const Components& components, Eigen::Index count) {
  MorphTargets morph;
  Matrix weights = components.weights.leftCols(count);
  for (Eigen::Index t = 0; t < count; ++t) {
    Eigen::Index frame = 0;
    weights.col(t).cwiseAbs().maxCoeff(&frame);
    const float scale = weights(frame, t) != 0 ? weights(frame, t) : 1;
    weights.col(t) /= scale;
    const Eigen::VectorXf target = components.directions.col(t) * scale;
    morph.add({target.data(), static_cast<std::size_t>(target.size())});
  }
  const Rows by_frame = weights;
  morph.weights.assign(by_frame.data(), by_frame.data() + by_frame.size());
  return morph;
}

}  // namespace

void for_frame_blocks(const FrameReader& read, std::size_t frames,
                      const std::function<void(std::size_t, std::size_t, std::span<const float>)>& body) {
  for (std::size_t first = 0; first < frames; first += block_frames) {
    const std::size_t count = std::min(block_frames, frames - first);
    body(first, count, read(first, count));
  }
}

MorphTargets principal_targets(const MorphTargets& spanning, const FrameReader& read, std::size_t frames,
                               double tolerance, const Parallel& parallel) {
  if (spanning.count == 0) return {};
  const Components components = components_of(spanning, read, frames, parallel);
  return targets_from(components, enough_components(components, tolerance, parallel));
}

MorphTargets leading_targets(const MorphTargets& spanning, const FrameReader& read, std::size_t frames,
                             std::size_t count, const Parallel& parallel) {
  if (spanning.count == 0 || count == 0) return {};
  const Components components = components_of(spanning, read, frames, parallel);
  return targets_from(components, std::min(index(count), components.weights.cols()));
}

}  // namespace fb::tool
