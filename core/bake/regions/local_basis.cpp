#include "bake/regions/local_basis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "bake/linalg/eigen_decomposition.h"
#include "bake/linalg/gemm.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Matrix = Eigen::MatrixXf;  // column-major: a column is a pose or a component

constexpr std::size_t task_poses = 64;      // projected by one worker at a time
constexpr std::size_t task_vertices = 192;  // whose products one worker sums at a time
constexpr std::size_t oversampling = 32;    // directions searched beyond max_components
constexpr std::size_t count_step = 8;       // resolution of the number of components

// Poses read at a time: at most 64 MiB.
std::size_t poses_per_read(std::size_t rows) {
  return std::clamp<std::size_t>((std::size_t(1) << 24) / rows / task_poses, 1, 8) * task_poses;
}

// State of the subspace iteration of one region.
struct RegionSubspace {
  const FaceRegion* region = nullptr;
  Matrix basis;                     // rows x width, orthonormal
  Matrix sum;                       // rows x width
  std::vector<float> coefficients;  // poses x width, in the basis

  std::size_t vertices() const { return region->vertices.size(); }
  std::size_t rows() const { return 3 * vertices(); }
  std::size_t width() const { return std::size_t(basis.cols()); }
};

// Weighted displacements of vertices [first, first + count) of a region in poses of `rows` floats: 3 x count x poses.
void gather_weighted(const FaceRegion& region, std::size_t first, std::size_t count, const float* values,
                     std::size_t rows, std::size_t poses, std::vector<float>& out) {
  out.resize(3 * count * poses);
  float* to = out.data();
  for (std::size_t pose = 0; pose < poses; ++pose)
    for (std::size_t i = first; i < first + count; ++i, to += 3) {
      const float* from = values + pose * rows + 3 * std::size_t(region.vertices[i]);
      const float weight = region.weights[i];
      for (int axis = 0; axis < 3; ++axis) to[axis] = weight * from[axis];
    }
}

// Calls body(region, first, count) for tiles of `tile` out of total(region), in parallel over all regions.
template <class Total, class Body>
void for_tiles(const Parallel& parallel, std::size_t regions, std::size_t tile, const Total& total, const Body& body) {
  struct Tile {
    std::size_t region, first, count;
  };
  std::vector<Tile> tiles;
  for (std::size_t r = 0; r < regions; ++r)
    for (std::size_t first = 0; first < total(r); first += tile)
      tiles.push_back({r, first, std::min(tile, total(r) - first)});
  parallel_for(parallel, tiles.size(),
               [&](std::size_t i, std::size_t) { body(tiles[i].region, tiles[i].first, tiles[i].count); });
}

// Calls body(region, first pose, count, weighted displacements) for a few poses of a block at a time.
template <class Body>
void for_region_poses(const Parallel& parallel, const std::vector<FaceRegion>& regions, std::size_t rows,
                      std::size_t poses, const float* values, const Body& body) {
  for_tiles(
      parallel, regions.size(), task_poses, [&](std::size_t) { return poses; },
      [&](std::size_t r, std::size_t first, std::size_t count) {
        std::vector<float> displacements;
        gather_weighted(regions[r], 0, regions[r].vertices.size(), values + first * rows, rows, count, displacements);
        body(r, first, count, displacements);
      });
}

void for_regions(const Parallel& parallel, std::vector<RegionSubspace>& subspaces,
                 const std::function<void(RegionSubspace&)>& body) {
  parallel_for(parallel, subspaces.size(), [&](std::size_t r, std::size_t) { body(subspaces[r]); });
}

// sum += displacements x factors^T; factors(region): poses x stride, of which the first sum.cols() are used.
template <class Factors>
void add_products(const Parallel& parallel, std::vector<RegionSubspace>& subspaces, std::size_t rows, std::size_t poses,
                  const float* values, const Factors& factors) {
  for_tiles(
      parallel, subspaces.size(), task_vertices, [&](std::size_t r) { return subspaces[r].vertices(); },
      [&](std::size_t r, std::size_t first, std::size_t count) {
        RegionSubspace& subspace = subspaces[r];
        std::vector<float> displacements;
        gather_weighted(*subspace.region, first, count, values, rows, poses, displacements);
        const auto [data, stride] = factors(r);
        gemm(Op::plain, Op::transposed, 3 * count, subspace.sum.cols(), poses, displacements.data(), 3 * count, data,
             stride, 1, subspace.sum.data() + 3 * first, subspace.rows());
      });
}

// Start: random linear combinations of the poses span most of their range.
void random_projection(const PoseRows& poses, std::size_t width, std::vector<RegionSubspace>& subspaces,
                       const Parallel& parallel, Progress& progress) {
  for (RegionSubspace& subspace : subspaces)
    subspace.sum = Matrix::Zero(subspace.rows(), std::min(width, subspace.rows()));
  progress.begin(Phase::training, "looking for local blendshapes", poses.size());
  for_blocks(poses, poses_per_read(poses.rows()), parallel, progress,
             [&](std::size_t first, std::size_t count, const float* values) {
               std::vector<float> factors(count * width);
               for (std::size_t i = 0; i < count; ++i) {
                 Random random = open_stream(0, Stream::local_basis, first + i);
                 for (std::size_t k = 0; k < width; ++k) factors[i * width + k] = random.normal();
               }
               add_products(parallel, subspaces, poses.rows(), count, values,
                            [&](std::size_t) { return std::pair(factors.data(), width); });
             });
  for_regions(parallel, subspaces, [](RegionSubspace& s) { s.basis = orthonormalise(s.sum, s.sum.cols()); });
}

// One step of subspace iteration; the basis comes out sorted by falling variance.
void iterate_subspaces(const PoseRows& poses, const std::vector<FaceRegion>& regions,
                       std::vector<RegionSubspace>& subspaces, const Parallel& parallel, Progress& progress) {
  const std::size_t block = poses_per_read(poses.rows());
  for (RegionSubspace& subspace : subspaces) {
    subspace.sum.setZero();
    subspace.coefficients.resize(block * subspace.width());
  }
  progress.begin(Phase::training, "finding local blendshapes", poses.size());
  for_blocks(poses, block, parallel, progress, [&](std::size_t, std::size_t count, const float* values) {
    for_region_poses(parallel, regions, poses.rows(), count, values,
                     [&](std::size_t r, std::size_t first, std::size_t n, std::vector<float>& displacements) {
                       RegionSubspace& s = subspaces[r];
                       gemm(Op::transposed, Op::plain, s.width(), n, s.rows(), s.basis.data(), s.rows(),
                            displacements.data(), s.rows(), 0, s.coefficients.data() + first * s.width(), s.width());
                     });
    add_products(parallel, subspaces, poses.rows(), count, values,
                 [&](std::size_t r) { return std::pair(subspaces[r].coefficients.data(), subspaces[r].width()); });
  });
  for_regions(parallel, subspaces, [](RegionSubspace& s) {
    Matrix inner(s.width(), s.width()), rotated(s.rows(), s.width());
    gemm(Op::transposed, Op::plain, s.width(), s.width(), s.rows(), s.basis.data(), s.rows(), s.sum.data(), s.rows(), 0,
         inner.data(), s.width());
    const Eigen::MatrixXd covariance = inner.cast<double>();
    const EigenDecomposition eigen = decompose_symmetric((covariance + covariance.transpose()) / 2);
    gemm(Op::plain, Op::plain, s.rows(), s.width(), s.width(), s.sum.data(), s.rows(), eigen.vectors.data(), s.width(),
         0, rotated.data(), s.rows());
    s.basis = orthonormalise(rotated, s.width());
    s.sum.resize(0, 0);
  });
}

// Truncation errors with 0, count_step, 2 x count_step, ... components.
struct TruncationErrors {
  std::vector<float> max_squared;  // largest squared distance at a vertex
  std::vector<double> squares;     // sum of squared distances

  void resize(std::size_t counts) {
    max_squared.resize(counts);
    squares.resize(counts);
  }
  void add(const TruncationErrors& other) {
    for (std::size_t i = 0; i < max_squared.size(); ++i) {
      max_squared[i] = std::max(max_squared[i], other.max_squared[i]);
      squares[i] += other.squares[i];
    }
  }
};

// The largest squared length of 3-vectors, and the sum; in independent lanes, so that additions do not wait for each
// other.
std::pair<float, double> squared_lengths(const float* vectors, std::size_t count) {
  constexpr std::size_t lanes = 8;
  float largest[lanes] = {}, sums[lanes] = {};
  const auto add = [&](std::size_t i, std::size_t lane) {
    const float* v = vectors + 3 * i;
    const float squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    largest[lane] = std::max(largest[lane], squared);
    sums[lane] += squared;
  };
  const std::size_t whole = count / lanes * lanes;
  for (std::size_t i = 0; i < whole; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) add(i + lane, lane);
  for (std::size_t i = whole; i < count; ++i) add(i, 0);
  return {*std::max_element(largest, largest + lanes), std::accumulate(sums, sums + lanes, 0.0)};
}

// Truncation errors of `poses` poses with up to max_count components: subtracts components, count_step at a time, from
// the displacements and measures the remainder.
TruncationErrors truncation_errors(const RegionSubspace& subspace, std::size_t max_count, std::size_t poses,
                                   const float* coefficients, std::vector<float>& displacements) {
  std::vector<float> negative(coefficients, coefficients + poses * subspace.width());
  for (float& c : negative) c = -c;
  TruncationErrors errors;
  for (std::size_t first = 0;; first += count_step) {
    errors.max_squared.push_back(0);
    errors.squares.push_back(0);
    for (std::size_t pose = 0; pose < poses; ++pose) {
      const auto [largest, sum] = squared_lengths(displacements.data() + pose * subspace.rows(), subspace.vertices());
      errors.max_squared.back() = std::max(errors.max_squared.back(), largest);
      errors.squares.back() += sum;
    }
    if (first >= max_count) return errors;
    gemm(Op::plain, Op::plain, subspace.rows(), poses, std::min(count_step, max_count - first),
         subspace.basis.data() + first * subspace.rows(), subspace.rows(), negative.data() + first, subspace.width(), 1,
         displacements.data(), subspace.rows());
  }
}

// Bound on the mean square along one direction that comes from rounding points to floats.
double rounding_variance(const Mesh& rest) {
  float largest = 0;
  for (const float value : rest.points) largest = std::max(largest, std::abs(value));
  return std::pow(4.0 * std::numeric_limits<float>::epsilon() * largest, 2);
}

// Rotates the first `count` components to their principal axes; axes with no more variance than `noise` are dropped.
void rotate_to_principal_axes(const RegionSubspace& subspace, std::size_t count, std::size_t poses, double noise,
                              LocalBasis& basis) {
  const Matrix kept = Eigen::Map<const Matrix>(subspace.coefficients.data(), subspace.width(), poses).topRows(count);
  const EigenDecomposition eigen = decompose_symmetric(gram_matrix(kept.data(), count, poses, {.threads = 1}));
  basis.rows = subspace.rows();
  basis.count = 1;
  while (basis.count < count && eigen.values[basis.count] > noise * double(poses)) ++basis.count;
  basis.components.resize(basis.count * basis.rows);
  gemm(Op::plain, Op::plain, basis.rows, basis.count, count, subspace.basis.data(), basis.rows, eigen.vectors.data(),
       count, 0, basis.components.data(), basis.rows);
}

// Measures the truncation error of every number of components, and keeps as many as max_error needs.
std::vector<LocalBasis> truncate(const PoseRows& poses, const std::vector<FaceRegion>& regions,
                                 const LocalBasisOptions& options, std::vector<RegionSubspace>& subspaces,
                                 const Parallel& parallel, Progress& progress) {
  const std::size_t block = poses_per_read(poses.rows()), tasks = block / task_poses;
  std::vector<std::size_t> max_counts;
  std::vector<TruncationErrors> errors(subspaces.size()), task_errors(subspaces.size() * tasks);
  for (std::size_t r = 0; r < subspaces.size(); ++r) {
    max_counts.push_back(std::min(options.max_components, subspaces[r].width()));
    errors[r].resize((max_counts[r] + count_step - 1) / count_step + 1);
    subspaces[r].coefficients.resize(poses.size() * subspaces[r].width());
  }
  progress.begin(Phase::training, "measuring local blendshapes", poses.size());
  for_blocks(poses, block, parallel, progress, [&](std::size_t start, std::size_t count, const float* values) {
    for_region_poses(parallel, regions, poses.rows(), count, values,
                     [&](std::size_t r, std::size_t first, std::size_t n, std::vector<float>& displacements) {
                       RegionSubspace& s = subspaces[r];
                       float* coefficients = s.coefficients.data() + (start + first) * s.width();
                       gemm(Op::transposed, Op::plain, s.width(), n, s.rows(), s.basis.data(), s.rows(),
                            displacements.data(), s.rows(), 0, coefficients, s.width());
                       task_errors[r * tasks + first / task_poses] =
                           truncation_errors(s, max_counts[r], n, coefficients, displacements);
                     });
    for (std::size_t r = 0; r < subspaces.size(); ++r)
      for (std::size_t t = 0; t * task_poses < count; ++t) errors[r].add(task_errors[r * tasks + t]);
  });

  const Mesh& rest = poses.poses().source().rest();
  const double diagonal = rest.diagonal(), noise = rounding_variance(rest);
  std::vector<LocalBasis> bases(subspaces.size());
  parallel_for(parallel, subspaces.size(), [&](std::size_t r, std::size_t) {
    const auto max_error = [&](std::size_t i) { return std::sqrt(double(errors[r].max_squared[i])) / diagonal; };
    std::size_t chosen = 1;
    while (chosen + 1 < errors[r].max_squared.size() && max_error(chosen) > options.max_error) ++chosen;
    rotate_to_principal_axes(subspaces[r], std::min(chosen * count_step, max_counts[r]), poses.size(), noise, bases[r]);
    bases[r].max_error = max_error(chosen);
    bases[r].rms_error =
        std::sqrt(errors[r].squares[chosen] / (double(poses.size()) * double(subspaces[r].vertices()))) / diagonal;
  });
  return bases;
}

// The coefficients of every pose.
void project_all(const PoseRows& poses, const std::vector<FaceRegion>& regions, std::vector<LocalBasis>& bases,
                 const Parallel& parallel, Progress& progress) {
  for (LocalBasis& basis : bases) basis.coefficients.resize(poses.size() * basis.count);
  progress.begin(Phase::training, "projecting poses", poses.size());
  for_blocks(poses, poses_per_read(poses.rows()), parallel, progress,
             [&](std::size_t start, std::size_t count, const float* values) {
               for_tiles(
                   parallel, regions.size(), task_poses, [&](std::size_t) { return count; },
                   [&](std::size_t r, std::size_t first, std::size_t n) {
                     const std::span residual(values + first * poses.rows(), n * poses.rows());
                     project_poses(regions[r], bases[r], residual, n,
                                   bases[r].coefficients.data() + (start + first) * bases[r].count);
                   });
             });
}

void check(const std::vector<FaceRegion>& regions, std::size_t vertices) {
  for (const FaceRegion& region : regions) {
    if (region.vertices.empty() || region.vertices.size() != region.weights.size())
      fail(Status::invalid_argument, "region \"%s\" has %zu vertices and %zu weights", region.name.c_str(),
           region.vertices.size(), region.weights.size());
    for (const std::uint32_t vertex : region.vertices)
      if (vertex >= vertices)
        fail(Status::invalid_argument, "region \"%s\" names vertex %u of %zu", region.name.c_str(), vertex, vertices);
  }
}

}  // namespace

std::vector<LocalBasis> local_bases(const PoseRows& to_fit, const PoseRows& all, const std::vector<FaceRegion>& regions,
                                    const LocalBasisOptions& options, const Parallel& parallel, Progress& progress) {
  check(regions, all.rows() / 3);
  if (options.max_components == 0 || options.max_fit_poses == 0 || to_fit.size() == 0)
    fail(Status::invalid_argument, "%zu components cannot be fitted to %zu of %zu poses", options.max_components,
         options.max_fit_poses, to_fit.size());
  if (regions.empty()) return {};
  const std::unique_ptr<PoseRows> some = to_fit.subsampled(options.max_fit_poses);
  const PoseRows& fitted = *some;
  const std::size_t width = std::min(options.max_components + oversampling, fitted.size());
  // The random projection needs a few times `width` poses only; the iteration corrects it with all.
  const std::unique_ptr<PoseRows> projected = fitted.subsampled(std::max(4 * width, fitted.size() / 4));

  std::vector<RegionSubspace> subspaces(regions.size());
  for (std::size_t r = 0; r < regions.size(); ++r) subspaces[r].region = &regions[r];
  random_projection(*projected, width, subspaces, parallel, progress);
  iterate_subspaces(fitted, regions, subspaces, parallel, progress);
  std::vector<LocalBasis> bases = truncate(fitted, regions, options, subspaces, parallel, progress);
  subspaces.clear();
  project_all(all, regions, bases, parallel, progress);
  return bases;
}

void project_poses(const FaceRegion& region, const LocalBasis& basis, std::span<const float> residual,
                   std::size_t poses, float* coefficients) {
  std::vector<float> weighted;
  gather_weighted(region, 0, region.vertices.size(), residual.data(), residual.size() / poses, poses, weighted);
  gemm(Op::transposed, Op::plain, basis.count, poses, basis.rows, basis.components.data(), basis.rows, weighted.data(),
       basis.rows, 0, coefficients, basis.count);
}

}  // namespace fb::bake
