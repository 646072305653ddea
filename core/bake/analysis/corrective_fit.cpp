#include "bake/analysis/corrective_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bake/analysis/blendshape_parts.h"

namespace fb::bake {
namespace {

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double least_gain = 0.15;   // of what is left, for a further term
constexpr double much_gain = 0.99;    // a term that takes this share is worth it below the tolerance too
constexpr double little = 0.01;       // of the tolerance: nothing is worth it below
constexpr double independent = 0.05;  // share of a candidate that what is picked must not hold already
constexpr double seen = 0.5;          // candidates are 1 at most: those that come nowhere near at any point are unknown
constexpr double largest_shape = 3;   // of the largest residual: shapes beyond balance each other at the points only
constexpr double needless = 1e-3;     // share of the energy taken that a picked feature may be missed by

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

// Values of the candidates at every point: points x candidates.
Eigen::MatrixXd values_at(std::span<const Feature> features, std::span<const std::uint32_t> candidates,
                          std::span<const float> poses, std::span<const float> rest) {
  const std::size_t points = poses.size() / rest.size();
  Eigen::MatrixXd table(static_cast<Eigen::Index>(points), static_cast<Eigen::Index>(candidates.size()));
  std::vector<float> values(features.size());
  for (std::size_t i = 0; i < points; ++i) {
    evaluate_features(features, poses.subspan(i * rest.size(), rest.size()), rest, values);
    for (std::size_t k = 0; k < candidates.size(); ++k)
      table(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = values[candidates[k]];
  }
  return table;
}

// What is left of the energies (points x points products of residuals) after the span of some columns is taken out.
double left_without(const Eigen::MatrixXd& energy, const Eigen::MatrixXd& columns) {
  if (columns.cols() == 0) return energy.trace();
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(columns).householderQ() *
                            Eigen::MatrixXd::Identity(columns.rows(), std::min(columns.rows(), columns.cols()));
  return energy.trace() - (q.transpose() * energy * q).trace();
}

Eigen::MatrixXd select(const Eigen::MatrixXd& table, std::span<const Eigen::Index> picked) {
  Eigen::MatrixXd columns(table.rows(), static_cast<Eigen::Index>(picked.size()));
  for (std::size_t k = 0; k < picked.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = table.col(picked[k]);
  return columns;
}

// Of rows of offsets, three a vertex.
double largest_distance(const Rows& rows) {
  double worst = 0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index k = 0; k < rows.cols(); k += 3) worst = std::max(worst, double(rows.row(i).segment<3>(k).norm()));
  return worst;
}

std::vector<Eigen::Index> pick_features(const Eigen::MatrixXd& table, Rows left, const CorrectiveLimits& limits) {
  const Eigen::MatrixXd all = (left * left.transpose()).cast<double>();
  Eigen::MatrixXd energy = all, rest_of = table;  // candidates less what is picked already
  std::vector<Eigen::Index> picked;
  while (picked.size() < limits.max_terms && picked.size() < static_cast<std::size_t>(table.rows())) {
    const double total = energy.trace(), distance = largest_distance(left);
    if (distance <= little * limits.tolerance) break;
    double best = 0;
    Eigen::Index chosen = -1;
    for (Eigen::Index k = 0; k < table.cols(); ++k) {
      const auto column = rest_of.col(k);
      const double length = column.squaredNorm();
      if (length <= independent * independent * table.col(k).squaredNorm()) continue;
      if (table.col(k).cwiseAbs().maxCoeff() < seen) continue;
      const double gain = column.dot(energy * column) / length;
      // The first candidates are the simplest.
      if (gain > 1.02 * best) best = gain, chosen = k;
    }
    if (chosen < 0 || best < (distance > limits.tolerance ? least_gain : much_gain) * total) break;
    picked.push_back(chosen);
    const Eigen::VectorXd q = rest_of.col(chosen).normalized();
    rest_of -= q * (q.transpose() * rest_of).eval();
    const Eigen::VectorXf qf = q.cast<float>();
    left -= qf * (qf.transpose() * left).eval();
    energy = (left * left.transpose()).cast<double>();
  }
  // A pick that later ones made needless goes.
  for (std::size_t k = 0; picked.size() > 1 && k < picked.size();) {
    std::vector<Eigen::Index> fewer = picked;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
    const double with = left_without(all, select(table, picked)), without = left_without(all, select(table, fewer));
    if (without - with < needless * (all.trace() - without) && without < 1.02 * with + 1e-9 * all.trace())
      picked = fewer, k = 0;
    else
      ++k;
  }
  return picked;
}

}  // namespace

std::vector<std::uint32_t> compose(std::vector<Feature>& features, std::span<const std::uint32_t> tuple,
                                   std::span<const std::uint32_t> single) {
  std::vector<std::uint32_t> composed;
  for (const auto kind : {Feature::Kind::product, Feature::Kind::minimum})
    for (const std::uint32_t a : tuple)
      for (const std::uint32_t b : single) {
        if (kind == Feature::Kind::minimum && !(never_negative(features, a) && never_negative(features, b))) continue;
        composed.push_back(add_feature(features, {kind, 0, 1, 0, 0, std::min(a, b), std::max(a, b)}));
      }
  return composed;
}

SparseBlendshapes fit_corrective(std::span<const Feature> features, std::span<const std::uint32_t> candidates,
                                 std::span<const float> poses, std::span<const float> rest,
                                 std::span<const std::vector<float>> residuals, const CorrectiveLimits& limits) {
  SparseBlendshapes terms;
  if (residuals.empty() || candidates.empty()) return terms;
  const std::size_t vertices = residuals[0].size() / 3;
  std::vector<std::uint32_t> moved;
  double largest = 0;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    double squares = 0;
    for (const std::vector<float>& r : residuals)
      squares = std::max(squares, double(r[3 * v]) * r[3 * v] + double(r[3 * v + 1]) * r[3 * v + 1] +
                                      double(r[3 * v + 2]) * r[3 * v + 2]);
    if (squares > limits.drop * limits.drop) moved.push_back(v);
    largest = std::max(largest, squares);
  }
  if (largest <= limits.tolerance * limits.tolerance) return terms;
  Rows rows(static_cast<Eigen::Index>(residuals.size()), static_cast<Eigen::Index>(3 * moved.size()));
  for (std::size_t i = 0; i < residuals.size(); ++i)
    for (std::size_t k = 0; k < moved.size(); ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        rows(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(3 * k + axis)) = residuals[i][3 * moved[k] + axis];
  const Eigen::MatrixXd table = values_at(features, candidates, poses, rest);
  std::vector<Eigen::Index> picked = pick_features(table, rows, limits);
  Rows shapes;
  for (; !picked.empty(); picked.pop_back()) {
    const Eigen::MatrixXd columns = select(table, picked);
    shapes = columns.completeOrthogonalDecomposition().pseudoInverse().cast<float>() * rows;
    if (largest_distance(shapes) <= largest_shape * std::sqrt(largest)) break;
  }
  std::vector<float> offsets(3 * vertices);
  for (std::size_t p = 0; p < picked.size(); ++p) {
    for (std::size_t k = 0; k < moved.size(); ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        offsets[3 * moved[k] + axis] = shapes(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(3 * k + axis));
    SparseShape shape = make_sparse(0, offsets, limits.drop);
    if (shape.vertices.empty()) continue;
    shape.feature = import_feature(terms.features, features, candidates[static_cast<std::size_t>(picked[p])]);
    terms.shapes.push_back(std::move(shape));
  }
  return terms;
}

}  // namespace fb::bake
