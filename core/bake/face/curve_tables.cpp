#include "bake/face/curve_tables.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "bake/linalg/eigen_decomposition.h"
#include "model/feature_values.h"

namespace fb::bake {
namespace {

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t most_direct_shapes = 24;  // of one control: activation curves of eight knots a side have fewer

// Some shapes of one control on the vertices that any of them moves: shapes x 3 x vertices.
struct ShapeRows {
  std::vector<std::uint32_t> vertices;
  Rows rows;

  explicit ShapeRows(const std::vector<const SparseShape*>& shapes) {
    std::set<std::uint32_t> moved;
    for (const SparseShape* shape : shapes) moved.insert(shape->vertices.begin(), shape->vertices.end());
    vertices.assign(moved.begin(), moved.end());
    rows.setZero(static_cast<Eigen::Index>(shapes.size()), 3 * static_cast<Eigen::Index>(vertices.size()));
    for (std::size_t s = 0; s < shapes.size(); ++s)
      for (std::size_t k = 0; k < shapes[s]->vertices.size(); ++k) {
        const auto v = std::lower_bound(vertices.begin(), vertices.end(), shapes[s]->vertices[k]) - vertices.begin();
        std::copy_n(shapes[s]->offsets.data() + 3 * k, 3, rows.row(static_cast<Eigen::Index>(s)).data() + 3 * v);
      }
  }
};

double largest_distance(const Rows& rows) {
  float worst = 0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index k = 0; k < rows.cols(); k += 3) worst = std::max(worst, rows.row(i).segment<3>(k).squaredNorm());
  return std::sqrt(double(worst));
}

// weights (shapes x rank) and orthonormal components (rank x 3 vertices), whose product is the rows.
struct Factors {
  Rows weights, components;
};

Factors factorise(const Rows& rows, double tolerance) {
  const EigenDecomposition eigen = decompose_symmetric((rows * rows.transpose()).cast<double>());
  Factors factors;
  Rows left = rows;
  for (Eigen::Index rank = 1; rank <= rows.rows() && eigen.values[rank - 1] > 0; ++rank) {
    const auto vectors = eigen.vectors.leftCols(rank);
    const Eigen::VectorXf sizes = eigen.values.head(rank).cwiseSqrt().cast<float>();
    factors.components = sizes.cwiseInverse().asDiagonal() * (vectors.transpose() * rows);
    factors.weights = rows * factors.components.transpose();
    left = rows - factors.weights * factors.components;
    if (largest_distance(left) <= tolerance) break;
  }
  return factors;
}

CurveTable make_table(const std::vector<const SparseShape*>& shapes, const ShapeRows& moved, const Factors& factors) {
  CurveTable table;
  table.region.vertices = moved.vertices;
  table.region.weights.assign(moved.vertices.size(), 1);
  table.basis.rows = static_cast<std::size_t>(factors.components.cols());
  table.basis.count = static_cast<std::size_t>(factors.components.rows());
  table.basis.components.assign(factors.components.data(), factors.components.data() + factors.components.size());
  DenseLayer layer;
  layer.inputs = static_cast<std::uint32_t>(shapes.size());
  layer.outputs = static_cast<std::uint32_t>(table.basis.count);
  layer.bias.assign(layer.outputs, 0);
  for (std::uint32_t o = 0; o < layer.outputs; ++o)
    for (std::uint32_t i = 0; i < layer.inputs; ++i) layer.weights.push_back(factors.weights(i, o));
  table.network.layers.push_back(std::move(layer));
  for (const SparseShape* shape : shapes) table.network.features.push_back(shape->feature);
  return table;
}

// The coefficients of a table in every pose.
std::vector<float> coefficients(const CurveTable& table, const std::vector<Feature>& features, const PoseSet& poses) {
  const std::vector<float> controls = poses.controls(), rest = poses.source().schema().rest_pose();
  const DenseLayer& layer = table.network.layers[0];
  std::vector<float> all(poses.size() * layer.outputs);
  for (std::size_t p = 0; p < poses.size(); ++p)
    for (std::size_t i = 0; i < layer.inputs; ++i) {
      const Feature& feature = features[table.network.features[i]];
      const float value = control_feature(feature, controls[p * rest.size() + feature.control], rest[feature.control]);
      for (std::size_t o = 0; o < layer.outputs && value != 0; ++o)
        all[p * layer.outputs + o] += layer.weights[o * layer.inputs + i] * value;
    }
  return all;
}

}  // namespace

std::vector<CurveTable> take_curve_tables(SparseBlendshapes& base, const PoseSet& poses, double tolerance) {
  const RigSchema& schema = poses.source().schema();
  std::map<std::uint32_t, std::vector<const SparseShape*>> of_control;
  for (const SparseShape& shape : base.shapes)
    if (const Feature& feature = base.features[shape.feature]; !feature.of_features())
      of_control[feature.control].push_back(&shape);
  std::vector<CurveTable> tables;
  std::set<std::uint32_t> taken;  // features
  for (const auto& [control, shapes] : of_control) {
    if (shapes.size() <= most_direct_shapes) continue;
    const ShapeRows moved(shapes);
    const Factors factors = factorise(moved.rows, tolerance * poses.source().rest().diagonal());
    if (2 * factors.components.rows() > factors.weights.rows()) continue;
    CurveTable table = make_table(shapes, moved, factors);
    table.region.name = table.network.name = schema.controls[control].name;
    table.region.controls = {control};
    table.basis.coefficients = coefficients(table, base.features, poses);
    taken.insert(table.network.features.begin(), table.network.features.end());
    tables.push_back(std::move(table));
  }
  std::erase_if(base.shapes, [&](const SparseShape& shape) { return taken.contains(shape.feature); });
  return tables;
}

}  // namespace fb::bake
