#include "bake/regions/local_basis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "bake/linalg/gemm.h"
#include "bake/linalg/spectrum.h"
#include "base/random.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Matrix = Eigen::MatrixXf;  // column-major: a column is a pose or a component

constexpr std::size_t piece_poses = 64;     // a worker projects at a time
constexpr std::size_t tile_vertices = 192;  // of which a worker makes sums at a time
constexpr std::size_t spare = 32;           // directions searched beyond those that can be kept
constexpr std::size_t level = 8;            // components are added so many at a time
constexpr std::uint64_t seed = 0x10ca1;

// Poses held together: at most 64 MiB of them.
std::size_t block_poses(std::size_t rows) {
  return std::clamp<std::size_t>((std::size_t(1) << 24) / rows / piece_poses, 1, 8) * piece_poses;
}

// A region while its basis is looked for.
struct Search {
  const FaceRegion* region = nullptr;
  Matrix subspace;                  // rows x width, orthonormal
  Matrix sum;                       // rows x width
  std::vector<float> coefficients;  // poses x width, in the subspace

  std::size_t vertices() const { return region->vertices.size(); }
  std::size_t rows() const { return 3 * vertices(); }
  std::size_t width() const { return std::size_t(subspace.cols()); }
};

// Shares of vertices [first, first + count) of a region in poses of `rows` numbers: 3 x count x poses.
void gather(const FaceRegion& region, std::size_t first, std::size_t count, const float* values, std::size_t rows,
            std::size_t poses, std::vector<float>& out) {
  out.resize(3 * count * poses);
  float* to = out.data();
  for (std::size_t pose = 0; pose < poses; ++pose)
    for (std::size_t i = first; i < first + count; ++i, to += 3) {
      const float* from = values + pose * rows + 3 * std::size_t(region.vertices[i]);
      const float weight = region.weights[i];
      for (int axis = 0; axis < 3; ++axis) to[axis] = weight * from[axis];
    }
}

// Calls body(region, first, count) for pieces of `size` out of total(region), all regions side by side.
template <class Total, class Body>
void for_pieces(const Parallel& parallel, std::size_t regions, std::size_t size, const Total& total, const Body& body) {
  struct Piece {
    std::size_t region, first, count;
  };
  std::vector<Piece> pieces;
  for (std::size_t r = 0; r < regions; ++r)
    for (std::size_t first = 0; first < total(r); first += size)
      pieces.push_back({r, first, std::min(size, total(r) - first)});
  parallel_for(parallel, pieces.size(),
               [&](std::size_t i, std::size_t) { body(pieces[i].region, pieces[i].first, pieces[i].count); });
}

// Looks at a block of poses: body(region, first, count, shares) for a few poses at a time.
template <class Body>
void for_shares(const Parallel& parallel, const std::vector<FaceRegion>& regions, std::size_t rows, std::size_t poses,
                const float* values, const Body& body) {
  for_pieces(
      parallel, regions.size(), piece_poses, [&](std::size_t) { return poses; },
      [&](std::size_t r, std::size_t first, std::size_t count) {
        std::vector<float> shares;
        gather(regions[r], 0, regions[r].vertices.size(), values + first * rows, rows, count, shares);
        body(r, first, count, shares);
      });
}

void for_regions(const Parallel& parallel, std::vector<Search>& searches, const std::function<void(Search&)>& body) {
  parallel_for(parallel, searches.size(), [&](std::size_t r, std::size_t) { body(searches[r]); });
}

// sum += shares x factors^T; factors(region): poses x stride, of which the first sum.cols() count.
template <class Factors>
void add_products(const Parallel& parallel, std::vector<Search>& searches, std::size_t rows, std::size_t poses,
                  const float* values, const Factors& factors) {
  for_pieces(
      parallel, searches.size(), tile_vertices, [&](std::size_t r) { return searches[r].vertices(); },
      [&](std::size_t r, std::size_t first, std::size_t count) {
        Search& search = searches[r];
        std::vector<float> shares;
        gather(*search.region, first, count, values, rows, poses, shares);
        const auto [data, stride] = factors(r);
        gemm(Op::plain, Op::transposed, 3 * count, search.sum.cols(), poses, shares.data(), 3 * count, data, stride, 1,
             search.sum.data() + 3 * first, search.rows());
      });
}

// First look: random combinations of poses span most of what they do.
void sketch(const PoseRows& poses, std::size_t width, std::vector<Search>& searches, const Parallel& parallel,
            Progress& progress) {
  for (Search& search : searches) search.sum = Matrix::Zero(search.rows(), std::min(width, search.rows()));
  progress.begin("looking for local blendshapes", poses.size());
  for_blocks(poses, block_poses(poses.rows()), parallel, progress,
             [&](std::size_t first, std::size_t count, const float* values) {
               std::vector<float> factors(count * width);
               for (std::size_t i = 0; i < count; ++i) {
                 Random random(seed, first + i);
                 for (std::size_t k = 0; k < width; ++k) factors[i * width + k] = random.normal();
               }
               add_products(parallel, searches, poses.rows(), count, values,
                            [&](std::size_t) { return std::pair(factors.data(), width); });
             });
  for_regions(parallel, searches, [](Search& s) { s.subspace = orthonormal(s.sum, s.sum.cols()); });
}

// One step of subspace iteration, and the directions found by falling variance.
void improve(const PoseRows& poses, const std::vector<FaceRegion>& regions, std::vector<Search>& searches,
             const Parallel& parallel, Progress& progress) {
  const std::size_t block = block_poses(poses.rows());
  for (Search& search : searches) {
    search.sum.setZero();
    search.coefficients.resize(block * search.width());
  }
  progress.begin("finding local blendshapes", poses.size());
  for_blocks(poses, block, parallel, progress, [&](std::size_t, std::size_t count, const float* values) {
    for_shares(parallel, regions, poses.rows(), count, values,
               [&](std::size_t r, std::size_t first, std::size_t n, std::vector<float>& shares) {
                 Search& s = searches[r];
                 gemm(Op::transposed, Op::plain, s.width(), n, s.rows(), s.subspace.data(), s.rows(), shares.data(),
                      s.rows(), 0, s.coefficients.data() + first * s.width(), s.width());
               });
    add_products(parallel, searches, poses.rows(), count, values,
                 [&](std::size_t r) { return std::pair(searches[r].coefficients.data(), searches[r].width()); });
  });
  for_regions(parallel, searches, [](Search& s) {
    Matrix inner(s.width(), s.width()), turned(s.rows(), s.width());
    gemm(Op::transposed, Op::plain, s.width(), s.width(), s.rows(), s.subspace.data(), s.rows(), s.sum.data(), s.rows(),
         0, inner.data(), s.width());
    const Eigen::MatrixXd covariance = inner.cast<double>();
    const Spectrum spectrum = symmetric_spectrum((covariance + covariance.transpose()) / 2);
    gemm(Op::plain, Op::plain, s.rows(), s.width(), s.width(), s.sum.data(), s.rows(), spectrum.vectors.data(),
         s.width(), 0, turned.data(), s.rows());
    s.subspace = orthonormal(turned, s.width());
    s.sum.resize(0, 0);
  });
}

// What is lost with 0, `level`, 2 x `level`, ... components.
struct Loss {
  std::vector<float> worst;     // largest squared distance at a vertex
  std::vector<double> squares;  // sum of squared distances

  void resize(std::size_t levels) {
    worst.resize(levels);
    squares.resize(levels);
  }
  void add(const Loss& other) {
    for (std::size_t l = 0; l < worst.size(); ++l) {
      worst[l] = std::max(worst[l], other.worst[l]);
      squares[l] += other.squares[l];
    }
  }
};

// Squared lengths of vectors: the largest, and their sum. Several at a time, for none waits for the one before.
std::pair<float, double> measure(const float* vectors, std::size_t count) {
  constexpr std::size_t lanes = 8;
  float worst[lanes] = {}, sums[lanes] = {};
  const auto look = [&](std::size_t i, std::size_t lane) {
    const float* v = vectors + 3 * i;
    const float squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    worst[lane] = std::max(worst[lane], squared);
    sums[lane] += squared;
  };
  const std::size_t whole = count / lanes * lanes;
  for (std::size_t i = 0; i < whole; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) look(i + lane, lane);
  for (std::size_t i = whole; i < count; ++i) look(i, 0);
  return {*std::max_element(worst, worst + lanes), std::accumulate(sums, sums + lanes, 0.0)};
}

// Takes components away from the shares of `poses` poses, level after level, and looks at what is left.
Loss peel(const Search& search, std::size_t limit, std::size_t poses, const float* coefficients,
          std::vector<float>& shares) {
  std::vector<float> negative(coefficients, coefficients + poses * search.width());
  for (float& c : negative) c = -c;
  Loss loss;
  for (std::size_t first = 0;; first += level) {
    loss.worst.push_back(0);
    loss.squares.push_back(0);
    for (std::size_t pose = 0; pose < poses; ++pose) {
      const auto [worst, sum] = measure(shares.data() + pose * search.rows(), search.vertices());
      loss.worst.back() = std::max(loss.worst.back(), worst);
      loss.squares.back() += sum;
    }
    if (first >= limit) return loss;
    gemm(Op::plain, Op::plain, search.rows(), poses, std::min(level, limit - first),
         search.subspace.data() + first * search.rows(), search.rows(), negative.data() + first, search.width(), 1,
         shares.data(), search.rows());
  }
}

// The mean square along a direction that the rounding of points to floats alone may make.
double rounding(const Mesh& rest) {
  float reach = 0;
  for (const float value : rest.points) reach = std::max(reach, std::abs(value));
  return std::pow(4.0 * std::numeric_limits<float>::epsilon() * reach, 2);
}

// Turns the first components into their own principal directions; those of no more than `noise` are left out.
void settle(const Search& search, std::size_t count, std::size_t poses, double noise, LocalBasis& basis) {
  const Matrix kept = Eigen::Map<const Matrix>(search.coefficients.data(), search.width(), poses).topRows(count);
  const Spectrum spectrum = symmetric_spectrum(gram_of(kept.data(), count, poses, {.threads = 1}));
  basis.rows = search.rows();
  basis.count = 1;
  while (basis.count < count && spectrum.values[basis.count] > noise * double(poses)) ++basis.count;
  basis.components.resize(basis.count * basis.rows);
  gemm(Op::plain, Op::plain, basis.rows, basis.count, count, search.subspace.data(), basis.rows,
       spectrum.vectors.data(), count, 0, basis.components.data(), basis.rows);
}

// Measures what any number of components loses, and keeps as many as are needed.
std::vector<LocalBasis> choose(const PoseRows& poses, const std::vector<FaceRegion>& regions,
                               const LocalBasisOptions& options, std::vector<Search>& searches,
                               const Parallel& parallel, Progress& progress) {
  const std::size_t block = block_poses(poses.rows()), pieces = block / piece_poses;
  std::vector<std::size_t> limits;
  std::vector<Loss> losses(searches.size()), parts(searches.size() * pieces);
  for (std::size_t r = 0; r < searches.size(); ++r) {
    limits.push_back(std::min(options.max_components, searches[r].width()));
    losses[r].resize((limits[r] + level - 1) / level + 1);
    searches[r].coefficients.resize(poses.size() * searches[r].width());
  }
  progress.begin("measuring local blendshapes", poses.size());
  for_blocks(poses, block, parallel, progress, [&](std::size_t start, std::size_t count, const float* values) {
    for_shares(parallel, regions, poses.rows(), count, values,
               [&](std::size_t r, std::size_t first, std::size_t n, std::vector<float>& shares) {
                 Search& s = searches[r];
                 float* coefficients = s.coefficients.data() + (start + first) * s.width();
                 gemm(Op::transposed, Op::plain, s.width(), n, s.rows(), s.subspace.data(), s.rows(), shares.data(),
                      s.rows(), 0, coefficients, s.width());
                 parts[r * pieces + first / piece_poses] = peel(s, limits[r], n, coefficients, shares);
               });
    for (std::size_t r = 0; r < searches.size(); ++r)
      for (std::size_t p = 0; p * piece_poses < count; ++p) losses[r].add(parts[r * pieces + p]);
  });

  const Mesh& rest = poses.poses().source().rest();
  const double diagonal = rest.diagonal(), noise = rounding(rest);
  std::vector<LocalBasis> bases(searches.size());
  parallel_for(parallel, searches.size(), [&](std::size_t r, std::size_t) {
    const auto error = [&](std::size_t l) { return std::sqrt(double(losses[r].worst[l])) / diagonal; };
    std::size_t chosen = 1;
    while (chosen + 1 < losses[r].worst.size() && error(chosen) > options.max_error) ++chosen;
    settle(searches[r], std::min(chosen * level, limits[r]), poses.size(), noise, bases[r]);
    bases[r].max_error = error(chosen);
    bases[r].rms_error =
        std::sqrt(losses[r].squares[chosen] / (double(poses.size()) * double(searches[r].vertices()))) / diagonal;
  });
  return bases;
}

void project_all(const PoseRows& poses, const std::vector<FaceRegion>& regions, std::vector<LocalBasis>& bases,
                 const Parallel& parallel, Progress& progress) {
  for (LocalBasis& basis : bases) basis.coefficients.resize(poses.size() * basis.count);
  progress.begin("projecting poses", poses.size());
  for_blocks(poses, block_poses(poses.rows()), parallel, progress,
             [&](std::size_t start, std::size_t count, const float* values) {
               for_shares(parallel, regions, poses.rows(), count, values,
                          [&](std::size_t r, std::size_t first, std::size_t n, std::vector<float>& shares) {
                            LocalBasis& b = bases[r];
                            gemm(Op::transposed, Op::plain, b.count, n, b.rows, b.components.data(), b.rows,
                                 shares.data(), b.rows, 0, b.coefficients.data() + (start + first) * b.count, b.count);
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

std::vector<LocalBasis> local_bases(const PoseRows& residual, const std::vector<FaceRegion>& regions,
                                    const LocalBasisOptions& options, const Parallel& parallel, Progress& progress) {
  check(regions, residual.rows() / 3);
  if (options.max_components == 0 || options.poses_to_fit == 0 || residual.size() == 0)
    fail(Status::invalid_argument, "%zu components cannot be fitted to %zu of %zu poses", options.max_components,
         options.poses_to_fit, residual.size());
  if (regions.empty()) return {};
  const std::unique_ptr<PoseRows> to_fit = residual.subsampled(options.poses_to_fit);
  const PoseRows& fitted = *to_fit;
  const std::size_t width = std::min(options.max_components + spare, fitted.size());
  // A few times the width is enough to draw the first subspace from; the next step corrects it with all.
  const std::unique_ptr<PoseRows> sketched = fitted.subsampled(std::max(4 * width, fitted.size() / 4));

  std::vector<Search> searches(regions.size());
  for (std::size_t r = 0; r < regions.size(); ++r) searches[r].region = &regions[r];
  sketch(*sketched, width, searches, parallel, progress);
  improve(fitted, regions, searches, parallel, progress);
  std::vector<LocalBasis> bases = choose(fitted, regions, options, searches, parallel, progress);
  searches.clear();
  project_all(residual, regions, bases, parallel, progress);
  return bases;
}

}  // namespace fb::bake
