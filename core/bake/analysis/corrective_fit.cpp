#include "bake/analysis/corrective_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bake/analysis/blendshape_parts.h"

namespace fb::bake {
namespace {

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double least_gain = 0.15;   // share of the residual's energy that a feature must explain
constexpr double much_gain = 0.99;    // the same below the tolerance
constexpr double negligible = 0.01;   // of the tolerance: a residual to stop at
constexpr double independent = 0.05;  // part of a feature that those selected before must leave unexplained
constexpr double observed = 0.5;      // largest value, of 1 possible, that a feature must have in some pose
constexpr double largest_shape = 3;   // times the largest residual: larger shapes cancel each other in the poses
constexpr double redundant = 1e-3;    // share of the explained energy that may be lost with a feature

// Whether a feature is at least 0 in every pose.
bool never_negative(std::span<const Feature> features, std::uint32_t index) {
  const Feature& f = features[index];
  switch (f.kind) {
    case Feature::Kind::identity:
      return false;
    case Feature::Kind::ramp:
    case Feature::Kind::hat:
      return true;
    default:
      return f.first == f.second || (never_negative(features, f.first) && never_negative(features, f.second));
  }
}

// Values of the candidates in every pose: poses x candidates.
Eigen::MatrixXd values_at(std::span<const Feature> features, std::span<const std::uint32_t> candidates,
                          std::span<const float> poses, std::span<const float> rest) {
  const std::size_t count = poses.size() / rest.size();
  Eigen::MatrixXd table(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(candidates.size()));
  std::vector<float> values(features.size());
  for (std::size_t i = 0; i < count; ++i) {
    evaluate_features(features, poses.subspan(i * rest.size(), rest.size()), rest, values);
    for (std::size_t k = 0; k < candidates.size(); ++k)
      table(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = values[candidates[k]];
  }
  return table;
}

// Energy of the residual that the span of some columns leaves, of energies as products of residuals: poses x poses.
double unexplained(const Eigen::MatrixXd& energy, const Eigen::MatrixXd& columns) {
  if (columns.cols() == 0) return energy.trace();
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(columns).householderQ() *
                            Eigen::MatrixXd::Identity(columns.rows(), std::min(columns.rows(), columns.cols()));
  return energy.trace() - (q.transpose() * energy * q).trace();
}

Eigen::MatrixXd select(const Eigen::MatrixXd& table, std::span<const Eigen::Index> selected) {
  Eigen::MatrixXd columns(table.rows(), static_cast<Eigen::Index>(selected.size()));
  for (std::size_t k = 0; k < selected.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = table.col(selected[k]);
  return columns;
}

// Of rows of offsets, three a vertex.
double largest_distance(const Rows& rows) {
  double worst = 0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index k = 0; k < rows.cols(); k += 3) worst = std::max(worst, double(rows.row(i).segment<3>(k).norm()));
  return worst;
}

// Removes selected features that later ones made redundant. energy: of the residuals before any was selected.
void remove_redundant(const Eigen::MatrixXd& table, const Eigen::MatrixXd& energy,
                      std::vector<Eigen::Index>& selected) {
  for (std::size_t k = 0; selected.size() > 1 && k < selected.size();) {
    std::vector<Eigen::Index> fewer = selected;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
    const double with = unexplained(energy, select(table, selected)),
                 without = unexplained(energy, select(table, fewer));
    if (without - with < redundant * (energy.trace() - without) && without < 1.02 * with + 1e-9 * energy.trace())
      selected = fewer, k = 0;
    else
      ++k;
  }
}

std::vector<Eigen::Index> select_features(const Eigen::MatrixXd& table, Rows residuals,
                                          const CorrectiveLimits& limits) {
  const Eigen::MatrixXd all = (residuals * residuals.transpose()).cast<double>();
  Eigen::MatrixXd energy = all, orthogonal = table;  // candidates less their part in the span of those selected
  std::vector<Eigen::Index> selected;
  while (selected.size() < limits.max_features && selected.size() < static_cast<std::size_t>(table.rows())) {
    const double total = energy.trace(), distance = largest_distance(residuals);
    if (distance <= negligible * limits.tolerance) break;
    double best = 0;
    Eigen::Index chosen = -1;
    for (Eigen::Index k = 0; k < table.cols(); ++k) {
      const auto column = orthogonal.col(k);
      const double length = column.squaredNorm();
      if (length <= independent * independent * table.col(k).squaredNorm()) continue;
      if (table.col(k).cwiseAbs().maxCoeff() < observed) continue;
      const double gain = column.dot(energy * column) / length;
      // Earlier candidates are simpler.
      if (gain > 1.02 * best) best = gain, chosen = k;
    }
    if (chosen < 0 || best < (distance > limits.tolerance ? least_gain : much_gain) * total) break;
    selected.push_back(chosen);
    const Eigen::VectorXd q = orthogonal.col(chosen).normalized();
    orthogonal -= q * (q.transpose() * orthogonal).eval();
    const Eigen::VectorXf qf = q.cast<float>();
    residuals -= qf * (qf.transpose() * residuals).eval();
    energy = (residuals * residuals.transpose()).cast<double>();
  }
  remove_redundant(table, all, selected);
  return selected;
}

// Vertices that some residual moves by more than `drop`, and the largest squared distance.
std::vector<std::uint32_t> moved_vertices(std::span<const std::vector<float>> residuals, double drop, double& largest) {
  std::vector<std::uint32_t> moved;
  largest = 0;
  for (std::uint32_t v = 0; v < residuals[0].size() / 3; ++v) {
    double squares = 0;
    for (const std::vector<float>& r : residuals)
      squares = std::max(squares, double(r[3 * v]) * r[3 * v] + double(r[3 * v + 1]) * r[3 * v + 1] +
                                      double(r[3 * v + 2]) * r[3 * v + 2]);
    if (squares > drop * drop) moved.push_back(v);
    largest = std::max(largest, squares);
  }
  return moved;
}

// Shapes of the selected features, a row each, by least squares. Drops the last selected while shapes are too large.
Rows fit_shapes(const Eigen::MatrixXd& table, const Rows& residuals, double largest,
                std::vector<Eigen::Index>& selected) {
  Rows shapes;
  for (; !selected.empty(); selected.pop_back()) {
    const Eigen::MatrixXd columns = select(table, selected);
    shapes = columns.completeOrthogonalDecomposition().pseudoInverse().cast<float>() * residuals;
    if (largest_distance(shapes) <= largest_shape * largest) break;
  }
  return shapes;
}

}  // namespace

std::vector<std::uint32_t> compose(std::vector<Feature>& features, std::span<const std::uint32_t> first,
                                   std::span<const std::uint32_t> second) {
  std::vector<std::uint32_t> composed;
  for (const auto kind : {Feature::Kind::product, Feature::Kind::minimum})
    for (const std::uint32_t a : first)
      for (const std::uint32_t b : second) {
        if (kind == Feature::Kind::minimum && !(never_negative(features, a) && never_negative(features, b))) continue;
        composed.push_back(add_feature(features, {kind, 0, 1, 0, 0, std::min(a, b), std::max(a, b)}));
      }
  return composed;
}

SparseBlendshapes fit_corrective(std::span<const Feature> features, std::span<const std::uint32_t> candidates,
                                 std::span<const float> poses, std::span<const float> rest,
                                 std::span<const std::vector<float>> residuals, const CorrectiveLimits& limits) {
  SparseBlendshapes corrective;
  if (residuals.empty() || candidates.empty()) return corrective;
  double largest = 0;
  const std::vector<std::uint32_t> moved = moved_vertices(residuals, limits.drop, largest);
  if (largest <= limits.tolerance * limits.tolerance) return corrective;
  Rows rows(static_cast<Eigen::Index>(residuals.size()), static_cast<Eigen::Index>(3 * moved.size()));
  for (std::size_t i = 0; i < residuals.size(); ++i)
    for (std::size_t k = 0; k < moved.size(); ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        rows(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(3 * k + axis)) = residuals[i][3 * moved[k] + axis];
  const Eigen::MatrixXd table = values_at(features, candidates, poses, rest);
  std::vector<Eigen::Index> selected = select_features(table, rows, limits);
  const Rows shapes = fit_shapes(table, rows, std::sqrt(largest), selected);
  std::vector<float> offsets(residuals[0].size());
  for (std::size_t p = 0; p < selected.size(); ++p) {
    for (std::size_t k = 0; k < moved.size(); ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        offsets[3 * moved[k] + axis] = shapes(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(3 * k + axis));
    SparseShape shape = make_sparse(0, offsets, limits.drop);
    if (shape.vertices.empty()) continue;
    shape.feature = import_feature(corrective.features, features, candidates[static_cast<std::size_t>(selected[p])]);
    corrective.shapes.push_back(std::move(shape));
  }
  return corrective;
}

}  // namespace fb::bake
