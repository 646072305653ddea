#include "bake/regions/localize.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bake/linalg/spectrum.h"
#include "bake/regions/vertex_chunks.h"
#include "base/status.h"

namespace fb {
namespace {

using Matrix = Eigen::MatrixXf;
using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The columns a region has in the basis, and the square root of its covariance: root x root^T.
struct Part {
  std::uint32_t first = 0, count = 0;
  Matrix root;
};

Part make_part(const Region& region, std::uint32_t first, const std::vector<float>& covariance) {
  const std::uint32_t n = region.layers.back().outputs;
  if (covariance.size() != std::size_t(n) * n)
    fail(Status::invalid_argument, "region \"%s\" has %u coefficients and a covariance of %zu numbers",
         region.name.c_str(), n, covariance.size());
  for (const float value : covariance)
    if (!std::isfinite(value))
      fail(Status::not_finite, "the covariance of region \"%s\" is not finite", region.name.c_str());
  const Eigen::MatrixXd given = Eigen::Map<const Matrix>(covariance.data(), n, n).cast<double>();
  const Spectrum spectrum = symmetric_spectrum((given + given.transpose()) / 2);
  return {first, n, spectrum.vectors * spectrum.values.cwiseSqrt().cast<float>().asDiagonal()};
}

// Columns [first, first + count) of a group: begin and end in its list.
std::pair<std::size_t, std::size_t> listed(const RowGroup& group, std::uint32_t first, std::uint32_t count) {
  const auto begin = std::lower_bound(group.columns.begin(), group.columns.end(), first);
  const auto end = std::lower_bound(begin, group.columns.end(), first + count);
  return {std::size_t(begin - group.columns.begin()), std::size_t(end - group.columns.begin())};
}

// Some columns on the rows of some vertices.
struct Columns {
  std::vector<std::uint32_t> numbers;  // ascending
  Matrix values;                       // 3 x vertices, a column each
};

// Finds the rows of vertices in a block-sparse basis.
class RowFinder {
 public:
  explicit RowFinder(const Basis& basis) : basis_(&basis), row_of_(basis.rows / 3), group_of_(basis.rows) {
    for (std::uint32_t i = 0; i < row_of_.size(); ++i) row_of_[basis.order.empty() ? i : basis.order[i]] = 3 * i;
    for (std::uint32_t g = 0; g < basis.groups.size(); ++g)
      std::fill_n(group_of_.begin() + basis.groups[g].first_row, basis.groups[g].row_count, g);
  }

  // Those of columns [first, first + count) that are not 0 on all of these vertices.
  Columns gather(std::span<const std::uint32_t> vertices, std::uint32_t first, std::uint32_t count) const {
    Matrix values = Matrix::Zero(3 * Eigen::Index(vertices.size()), count);
    for (std::size_t i = 0; i < 3 * vertices.size(); ++i) {
      const std::uint32_t row = row_of_[vertices[i / 3]] + std::uint32_t(i % 3);
      const RowGroup& group = basis_->groups[group_of_[row]];
      const auto [begin, end] = listed(group, first, count);
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

// The region whose coefficients move a vertex most, or the number of regions.
std::vector<std::uint32_t> strongest_regions(const Basis& basis, const std::vector<Part>& parts,
                                             const Parallel& parallel) {
  std::vector<float> strength(basis.rows * parts.size(), 0);  // squared motion by row and region
  parallel_for(parallel, basis.groups.size(), [&](std::size_t g, std::size_t) {
    const RowGroup& group = basis.groups[g];
    for (std::size_t r = 0; r < parts.size(); ++r) {
      const auto [begin, end] = listed(group, parts[r].first, parts[r].count);
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

// A region's columns in a chunk, as they are and in fewer of its own.
struct Local {
  Columns old;
  Matrix directions;         // 3 x vertices, orthonormal columns
  Matrix projection;         // directions^T x old values
  std::vector<float> sizes;  // root mean square of each new coefficient
};

struct Chunk {
  std::vector<std::uint32_t> vertices;
  Columns direct;
  std::vector<Local> regions;
};

// Principal directions that move the region's vertices here by more than `threshold` (root mean square, rig's units).
Local make_local(Columns old, const Part& part, double threshold) {
  Local local{std::move(old), {}, {}, {}};
  const Matrix& values = local.old.values;
  local.directions.resize(values.rows(), 0);
  local.projection.resize(0, values.cols());
  if (values.cols() == 0) return local;
  Matrix root(values.cols(), part.count);
  for (Eigen::Index c = 0; c < values.cols(); ++c)
    root.row(c) = part.root.row(local.old.numbers[std::size_t(c)] - part.first);
  const Eigen::MatrixXd motion = (values * root).cast<double>();
  const Spectrum spectrum = symmetric_spectrum(motion * motion.transpose());
  Eigen::Index moved = 0;  // vertices
  for (Eigen::Index v = 0; v < values.rows() / 3; ++v) moved += !values.middleRows(3 * v, 3).isZero(0);
  // What is smaller than the rounding of the largest motion is no direction.
  constexpr double rounding = 1e-14;
  const double least = std::max(threshold * threshold * double(moved), spectrum.values[0] * rounding);
  const Eigen::Index most = std::min(values.rows(), values.cols());
  Eigen::Index kept = 0;
  while (kept < most && spectrum.values[kept] > least) ++kept;
  local.directions = spectrum.vectors.leftCols(kept);
  local.projection = local.directions.transpose() * values;
  for (Eigen::Index k = 0; k < kept; ++k) local.sizes.push_back(float(std::sqrt(spectrum.values[k])));
  return local;
}

// Whether a region's new columns and output layer hold fewer numbers than the old.
bool pays(const std::vector<Chunk>& chunks, std::size_t r, const DenseLayer& last) {
  if (last.activation != Activation::linear || last.skip) return false;
  const std::size_t row = std::size_t(last.inputs) + 1;  // weights and bias of one output
  std::size_t before = row * last.outputs, after = 0;
  for (const Chunk& chunk : chunks) {
    before += std::size_t(chunk.regions[r].old.values.size());
    after += std::size_t(chunk.regions[r].directions.size()) + chunk.regions[r].sizes.size() * row;
  }
  return after < before;
}

// The last layer giving every chunk's own coefficients, chunk after chunk.
DenseLayer merged(const DenseLayer& last, const std::vector<Chunk>& chunks, std::size_t r, const Part& part) {
  DenseLayer layer = last;
  layer.outputs = 0;
  layer.weights.clear();
  layer.bias.clear();
  const Eigen::Map<const RowMatrix> weights(last.weights.data(), last.outputs, last.inputs);
  for (const Chunk& chunk : chunks) {
    const Local& local = chunk.regions[r];
    RowMatrix rows(local.projection.cols(), last.inputs);
    Eigen::VectorXf bias(rows.rows());
    for (Eigen::Index c = 0; c < rows.rows(); ++c) {
      const std::uint32_t output = local.old.numbers[std::size_t(c)] - part.first;
      rows.row(c) = weights.row(output);
      bias[c] = last.bias[output];
    }
    const RowMatrix turned = local.projection * rows;
    const Eigen::VectorXf turned_bias = local.projection * bias;
    layer.outputs += std::uint32_t(turned.rows());
    layer.weights.insert(layer.weights.end(), turned.data(), turned.data() + turned.size());
    layer.bias.insert(layer.bias.end(), turned_bias.data(), turned_bias.data() + turned_bias.size());
  }
  return layer;
}

void append(RowGroup& group, std::uint32_t column, const Matrix& values, Eigen::Index c) {
  group.columns.push_back(column);
  group.values.insert(group.values.end(), values.col(c).data(), values.col(c).data() + values.rows());
}

}  // namespace

LocalizedModel localize_basis(const FaceModel& model, std::span<const std::vector<float>> covariance,
                              const LocalizeOptions& options, const Parallel& parallel) {
  check(model);
  const Network& network = model.network;
  if (covariance.size() != network.regions.size())
    fail(Status::invalid_argument, "%zu covariances for %zu regions", covariance.size(), network.regions.size());
  const auto direct = std::uint32_t(network.direct.size());
  std::vector<Part> parts;
  std::uint32_t next = direct;
  for (std::size_t r = 0; r < covariance.size(); next += parts[r].count, ++r)
    parts.push_back(make_part(network.regions[r], next, covariance[r]));

  std::vector<Chunk> chunks;
  const std::vector<std::uint32_t> labels = strongest_regions(model.basis, parts, parallel);
  for (auto& vertices : vertex_chunks(model.rest, labels, options.chunk_vertices))
    chunks.push_back({std::move(vertices), {}, {}});
  const RowFinder finder(model.basis);
  const double threshold = options.threshold * model.rest.diagonal();
  parallel_for(parallel, chunks.size(), [&](std::size_t i, std::size_t) {
    Chunk& chunk = chunks[i];
    chunk.direct = finder.gather(chunk.vertices, 0, direct);
    for (const Part& part : parts)
      chunk.regions.push_back(make_local(finder.gather(chunk.vertices, part.first, part.count), part, threshold));
  });

  LocalizedModel result{model, std::vector<float>(direct, 1.0f)};
  Basis& basis = result.model.basis;
  basis = {model.basis.rows, direct, {}, {}};
  for (const Chunk& chunk : chunks) {
    const auto rows = 3 * std::uint32_t(chunk.vertices.size());
    RowGroup& group = basis.groups.emplace_back(RowGroup{3 * std::uint32_t(basis.order.size()), rows, {}, {}});
    basis.order.insert(basis.order.end(), chunk.vertices.begin(), chunk.vertices.end());
    for (std::size_t c = 0; c < chunk.direct.numbers.size(); ++c)
      append(group, chunk.direct.numbers[c], chunk.direct.values, Eigen::Index(c));
  }
  for (std::size_t r = 0; r < parts.size(); ++r) {
    DenseLayer& last = result.model.network.regions[r].layers.back();
    const bool local = pays(chunks, r, last);
    if (local) last = merged(last, chunks, r, parts[r]);
    std::uint32_t own = basis.columns;  // the next chunk's first
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      const Local& part = chunks[i].regions[r];
      for (std::size_t c = 0; local && c < part.sizes.size(); ++c) {
        append(basis.groups[i], own++, part.directions, Eigen::Index(c));
        result.coefficient_sizes.push_back(part.sizes[c]);
      }
      for (std::size_t c = 0; !local && c < part.old.numbers.size(); ++c)
        append(basis.groups[i], basis.columns + part.old.numbers[c] - parts[r].first, part.old.values, Eigen::Index(c));
    }
    for (Eigen::Index c = 0; !local && c < parts[r].root.rows(); ++c)
      result.coefficient_sizes.push_back(parts[r].root.row(c).norm());
    basis.columns += last.outputs;
  }
  std::erase_if(result.model.network.regions, [](const Region& region) { return region.layers.back().outputs == 0; });
  check(result.model);
  return result;
}

}  // namespace fb
