#include "bake/compress/blockwise_pca.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bake/compress/vertex_blocks.h"
#include "bake/linalg/eigen_decomposition.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Matrix = Eigen::MatrixXf;
using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Columns of a region in the basis, and a square root of its covariance, root x root^T.
struct RegionColumns {
  std::uint32_t first = 0, count = 0;
  Matrix root;
};

RegionColumns region_columns(const Region& region, std::uint32_t first, const std::vector<float>& covariance) {
  const std::uint32_t n = region.layers.back().outputs;
  if (covariance.size() != std::size_t(n) * n)
    fail(Status::invalid_argument, "region \"%s\" has %u coefficients and a covariance of %zu numbers",
         region.name.c_str(), n, covariance.size());
  for (const float value : covariance)
    if (!std::isfinite(value))
      fail(Status::not_finite, "the covariance of region \"%s\" is not finite", region.name.c_str());
  const Eigen::MatrixXd given = Eigen::Map<const Matrix>(covariance.data(), n, n).cast<double>();
  const EigenDecomposition eigen = decompose_symmetric((given + given.transpose()) / 2);
  return {first, n, eigen.vectors * eigen.values.cwiseSqrt().cast<float>().asDiagonal()};
}

// Range within group.columns of the columns [first, first + count).
std::pair<std::size_t, std::size_t> column_range(const RowBlock& group, std::uint32_t first, std::uint32_t count) {
  const auto begin = std::lower_bound(group.columns.begin(), group.columns.end(), first);
  const auto end = std::lower_bound(begin, group.columns.end(), first + count);
  return {std::size_t(begin - group.columns.begin()), std::size_t(end - group.columns.begin())};
}

// A submatrix of the basis: some columns on the rows of some vertices.
struct Columns {
  std::vector<std::uint32_t> numbers;  // ascending
  Matrix values;                       // 3 vertices x columns
};

// Finds the rows of vertices in a block-sparse basis.
class RowFinder {
 public:
  explicit RowFinder(const Basis& basis) : basis_(&basis), row_of_(basis.rows / 3), group_of_(basis.rows) {
    for (std::uint32_t i = 0; i < row_of_.size(); ++i) row_of_[basis.order.empty() ? i : basis.order[i]] = 3 * i;
    for (std::uint32_t g = 0; g < basis.row_blocks.size(); ++g)
      std::fill_n(group_of_.begin() + basis.row_blocks[g].first_row, basis.row_blocks[g].row_count, g);
  }

  // Those of columns [first, first + count) that are not 0 at all of these vertices.
  Columns gather(std::span<const std::uint32_t> vertices, std::uint32_t first, std::uint32_t count) const {
    Matrix values = Matrix::Zero(3 * Eigen::Index(vertices.size()), count);
    for (std::size_t i = 0; i < 3 * vertices.size(); ++i) {
      const std::uint32_t row = row_of_[vertices[i / 3]] + std::uint32_t(i % 3);
      const RowBlock& group = basis_->row_blocks[group_of_[row]];
      const auto [begin, end] = column_range(group, first, count);
      for (std::size_t c = begin; c < end; ++c)
        values(Eigen::Index(i), group.columns[c] - first) = group.values[c * group.row_count + row - group.first_row];
    }
    Columns columns;
    for (std::uint32_t c = 0; c < count; ++c)
      if (!values.col(c).isZero(0)) columns.numbers.push_back(first + c);
    columns.values.resize(values.rows(), Eigen::Index(columns.numbers.size()));
    for (std::size_t c = 0; c < columns.numbers.size(); ++c)
      columns.values.col(Eigen::Index(c)) = values.col(columns.numbers[c] - first);
    return columns;
  }

 private:
  const Basis* basis_;
  std::vector<std::uint32_t> row_of_, group_of_;  // of a vertex, of a row
};

// By vertex: the region whose coefficients move it most, or the number of regions if none does.
std::vector<std::uint32_t> strongest_regions(const Basis& basis, const std::vector<RegionColumns>& parts,
                                             const Parallel& parallel) {
  std::vector<float> strength(basis.rows * parts.size(), 0);  // squared motion by row and region
  parallel_for(parallel, basis.row_blocks.size(), [&](std::size_t g, std::size_t) {
    const RowBlock& group = basis.row_blocks[g];
    for (std::size_t r = 0; r < parts.size(); ++r) {
      const auto [begin, end] = column_range(group, parts[r].first, parts[r].count);
      Matrix motion = Matrix::Zero(group.row_count, parts[r].count);
      const Eigen::Map<const Matrix> values(group.values.data(), group.row_count, Eigen::Index(group.columns.size()));
      for (std::size_t c = begin; c < end; ++c)
        motion += values.col(Eigen::Index(c)) * parts[r].root.row(group.columns[c] - parts[r].first);
      for (std::uint32_t i = 0; i < group.row_count; ++i)
        strength[(group.first_row + i) * parts.size() + r] = motion.row(i).squaredNorm();
    }
  });
  std::vector<std::uint32_t> labels(basis.rows / 3, std::uint32_t(parts.size()));
  for (std::size_t i = 0; i < labels.size(); ++i) {
    float most = 0;
    for (std::size_t r = 0; r < parts.size(); ++r) {
      float sum = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) sum += strength[(3 * i + axis) * parts.size() + r];
      if (sum <= most) continue;
      most = sum;
      labels[basis.order.empty() ? i : basis.order[i]] = std::uint32_t(r);
    }
  }
  return labels;
}

// A region in a block: its columns there, and the principal directions of its motion.
struct BlockRegion {
  Columns old;
  Matrix directions;                // 3 vertices x directions, orthonormal, by falling motion
  std::vector<double> motion = {};  // root mean square length along each, rig's units
  std::size_t moved = 0;            // number of vertices that the region moves

  // Number of directions with more motion than this, root mean square per moved vertex.
  Eigen::Index kept(double threshold) const {
    const double least = threshold * std::sqrt(double(moved));
    return std::partition_point(motion.begin(), motion.end(), [&](double m) { return m > least; }) - motion.begin();
  }
};

struct VertexBlock {
  std::vector<std::uint32_t> vertices;
  Columns direct;
  std::vector<BlockRegion> regions;
};

BlockRegion block_region(Columns old, const RegionColumns& region) {
  BlockRegion local{std::move(old), {}};
  const Matrix& values = local.old.values;
  local.directions.resize(values.rows(), 0);
  if (values.cols() == 0) return local;
  std::vector<Eigen::Index> rows;  // of moved vertices
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    if (!values.middleRows(row / 3 * 3, 3).isZero(0)) rows.push_back(row);
  local.moved = rows.size() / 3;
  Matrix root(values.cols(), region.count);
  for (Eigen::Index c = 0; c < values.cols(); ++c)
    root.row(c) = region.root.row(local.old.numbers[std::size_t(c)] - region.first);
  const Matrix part = values(rows, Eigen::seqN(0, values.cols()));
  const Eigen::MatrixXd motion = (part * root).cast<double>();
  const EigenDecomposition eigen = decompose_symmetric(motion * motion.transpose());
  // Eigenvalues below the rounding error of the largest one are 0.
  constexpr double rounding = 1e-14;
  Eigen::Index count = 0;
  while (count < std::min(part.rows(), part.cols()) && eigen.values[count] > eigen.values[0] * rounding) ++count;
  local.directions = Matrix::Zero(values.rows(), count);
  local.directions(rows, Eigen::seqN(0, count)) = eigen.vectors.leftCols(count);
  for (Eigen::Index k = 0; k < count; ++k) local.motion.push_back(std::sqrt(eigen.values[k]));
  return local;
}

// Whether a region's new columns and output layer have fewer numbers than the old.
bool has_fewer_numbers(const std::vector<VertexBlock>& blocks, std::size_t r, const DenseLayer& last,
                       double threshold) {
  if (last.activation != Activation::linear || last.skip) return false;
  const std::size_t row = std::size_t(last.inputs) + 1;  // weights and bias of one output
  std::size_t before = row * last.outputs, after = 0;
  for (const VertexBlock& block : blocks) {
    const BlockRegion& local = block.regions[r];
    before += std::size_t(local.old.values.size());
    after += std::size_t(local.kept(threshold)) * (3 * block.vertices.size() + row);
  }
  return after < before;
}

// The last layer followed by the projections of all blocks: its outputs are the coefficients of block after block.
DenseLayer merge_projections(const DenseLayer& last, const std::vector<VertexBlock>& blocks, std::size_t r,
                             std::uint32_t first, double threshold) {
  DenseLayer layer = last;
  layer.outputs = 0;
  layer.weights.clear();
  layer.bias.clear();
  const Eigen::Map<const RowMatrix> weights(last.weights.data(), last.outputs, last.inputs);
  for (const VertexBlock& block : blocks) {
    const BlockRegion& local = block.regions[r];
    RowMatrix rows(local.old.values.cols(), last.inputs);
    Eigen::VectorXf bias(rows.rows());
    for (Eigen::Index c = 0; c < rows.rows(); ++c) {
      const std::uint32_t output = local.old.numbers[std::size_t(c)] - first;
      rows.row(c) = weights.row(output);
      bias[c] = last.bias[output];
    }
    const Matrix projection = local.directions.leftCols(local.kept(threshold)).transpose() * local.old.values;
    const RowMatrix projected = projection * rows;
    const Eigen::VectorXf projected_bias = projection * bias;
    layer.outputs += std::uint32_t(projected.rows());
    layer.weights.insert(layer.weights.end(), projected.data(), projected.data() + projected.size());
    layer.bias.insert(layer.bias.end(), projected_bias.data(), projected_bias.data() + projected_bias.size());
  }
  return layer;
}

void append(RowBlock& group, std::uint32_t column, const Matrix& values, Eigen::Index c) {
  group.columns.push_back(column);
  group.values.insert(group.values.end(), values.col(c).data(), values.col(c).data() + values.rows());
}

}  // namespace

struct BlockwisePca::Parts {
  FaceModel model;
  std::vector<float> direct_sizes;
  std::vector<RegionColumns> regions;
  std::vector<VertexBlock> blocks;
};

BlockwisePca::BlockwisePca(const FaceModel& model, std::span<const std::vector<float>> covariance,
                           std::uint32_t block_vertices, const Parallel& parallel,
                           std::span<const float> direct_sizes) {
  check(model);
  const Network& network = model.network;
  if (covariance.size() != network.regions.size())
    fail(Status::invalid_argument, "%zu covariances for %zu regions", covariance.size(), network.regions.size());
  const auto direct = std::uint32_t(network.direct.size());
  auto parts = std::make_unique<Parts>(Parts{model, {direct_sizes.begin(), direct_sizes.end()}, {}, {}});
  if (direct_sizes.empty()) parts->direct_sizes.assign(direct, 1.0f);
  if (parts->direct_sizes.size() != direct)
    fail(Status::invalid_argument, "%zu sizes for %u direct coefficients", direct_sizes.size(), direct);
  std::uint32_t next = direct;
  for (std::size_t r = 0; r < covariance.size(); next += parts->regions[r].count, ++r)
    parts->regions.push_back(region_columns(network.regions[r], next, covariance[r]));

  const std::vector<std::uint32_t> labels = strongest_regions(model.basis, parts->regions, parallel);
  for (auto& vertices : vertex_blocks(model.rest, labels, block_vertices, model.coarsest_levels))
    parts->blocks.push_back({std::move(vertices), {}, {}});
  const RowFinder finder(model.basis);
  parallel_for(parallel, parts->blocks.size(), [&](std::size_t i, std::size_t) {
    VertexBlock& block = parts->blocks[i];
    block.direct = finder.gather(block.vertices, 0, direct);
    for (const RegionColumns& region : parts->regions)
      block.regions.push_back(block_region(finder.gather(block.vertices, region.first, region.count), region));
  });
  parts_ = std::move(parts);
}

BlockwisePca::~BlockwisePca() = default;

BlockwiseModel BlockwisePca::truncated(double threshold_over_diagonal) const {
  const auto& [model, direct_sizes, regions, blocks] = *parts_;
  const double threshold = threshold_over_diagonal * model.rest.diagonal();
  const auto direct = std::uint32_t(model.network.direct.size());
  BlockwiseModel result{model, direct_sizes};
  Basis& basis = result.model.basis;
  basis = {model.basis.rows, direct, {}, {}};
  for (const VertexBlock& block : blocks) {
    const auto rows = 3 * std::uint32_t(block.vertices.size());
    RowBlock& group = basis.row_blocks.emplace_back(RowBlock{3 * std::uint32_t(basis.order.size()), rows, {}, {}});
    basis.order.insert(basis.order.end(), block.vertices.begin(), block.vertices.end());
    for (std::size_t c = 0; c < block.direct.numbers.size(); ++c)
      append(group, block.direct.numbers[c], block.direct.values, Eigen::Index(c));
  }
  for (std::size_t r = 0; r < regions.size(); ++r) {
    DenseLayer& last = result.model.network.regions[r].layers.back();
    const bool local = has_fewer_numbers(blocks, r, last, threshold);
    if (local) last = merge_projections(last, blocks, r, regions[r].first, threshold);
    std::uint32_t own = basis.columns;  // first column of the next block
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const BlockRegion& part = blocks[i].regions[r];
      for (Eigen::Index c = 0; local && c < part.kept(threshold); ++c) {
        append(basis.row_blocks[i], own++, part.directions, c);
        result.coefficient_sizes.push_back(float(part.motion[std::size_t(c)]));
      }
      for (std::size_t c = 0; !local && c < part.old.numbers.size(); ++c)
        append(basis.row_blocks[i], basis.columns + part.old.numbers[c] - regions[r].first, part.old.values,
               Eigen::Index(c));
    }
    for (Eigen::Index c = 0; !local && c < regions[r].root.rows(); ++c)
      result.coefficient_sizes.push_back(regions[r].root.row(c).norm());
    basis.columns += last.outputs;
  }
  std::erase_if(result.model.network.regions, [](const Region& region) { return region.layers.back().outputs == 0; });
  check(result.model);
  return result;
}

BlockwiseModel blockwise_pca(const FaceModel& model, std::span<const std::vector<float>> covariance,
                             const BlockwisePcaOptions& options, const Parallel& parallel) {
  return BlockwisePca(model, covariance, options.block_vertices, parallel).truncated(options.threshold);
}

}  // namespace fb::bake
