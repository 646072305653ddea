// How near the basis of a face's networks comes to poses, whatever the networks give.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "bake/measure/float_face.h"
#include "bake/rig/driven_pose.h"
#include "model/face_model.h"

namespace fb::bench {

// The shapes that are not left to networks stay as the face has them; coefficients of the others are fitted to each
// pose by least squares, before driven joints skin it.
class BestFit {
 public:
  // `model` must outlive this. Memory: a float for each row and coefficient of the networks.
  explicit BestFit(const FaceModel& model)
      : model_(model),
        face_(model),
        first_(model.network.direct.size()),
        shapes_(Eigen::MatrixXf::Zero(model.basis.rows, model.basis.columns - std::ptrdiff_t(first_))) {
    for_values([&](std::size_t row, std::size_t column, float value) {
      if (column >= first_) shapes_(std::ptrdiff_t(row), std::ptrdiff_t(column - first_)) = value;
    });
    Eigen::MatrixXd products = (shapes_.transpose() * shapes_).cast<double>();
    products.diagonal().array() += 1e-9 * products.diagonal().maxCoeff();
    products_.compute(products);
  }

  // `points`: of the rig, in its source's order; `positions`: of the fitted face, 3 x vertices.
  void fit(std::span<const float> controls, std::span<const float> points, std::span<float> positions) const {
    std::vector<float> left(points.begin(), points.end());
    bake::points_to_displacements(model_.rest, left);
    const std::vector<double> coefficients = face_.coefficients(controls);
    std::vector<float> shown(left.size());  // displacement by the shapes that are not left to networks
    for_values([&](std::size_t row, std::size_t column, float value) {
      if (column < first_) shown[row] += static_cast<float>(value * coefficients[column]);
    });
    Eigen::Map<const Eigen::VectorXf> target(left.data(), std::ptrdiff_t(left.size()));
    Eigen::Map<Eigen::VectorXf> displacement(shown.data(), std::ptrdiff_t(shown.size()));
    const Eigen::VectorXf wanted = shapes_.transpose() * (target - displacement);
    displacement += shapes_ * products_.solve(wanted.cast<double>()).cast<float>();

    std::vector<double> posed(shown.size());
    for (std::size_t i = 0; i < posed.size(); ++i) posed[i] = double(model_.rest.points[i]) + shown[i];
    if (!model_.rest.driven.empty()) {
      const std::size_t surface = model_.rest.first_joint_coordinate();
      std::vector<float> numbers(posed.begin() + std::ptrdiff_t(surface), posed.end());
      bake::add_driven_skin(model_.rest, bake::joint_motions(model_.rest.driven, numbers),
                            std::span(posed).first(3 * model_.rest.surface_vertex_count()));
    }
    std::copy(posed.begin(), posed.end(), positions.begin());
  }

 private:
  // visit(row in source order, column, value)
  template <class Visit>
  void for_values(const Visit& visit) const {
    const Basis& basis = model_.basis;
    for (const RowBlock& block : basis.row_blocks)
      for (std::size_t c = 0; c < block.columns.size(); ++c)
        for (std::size_t r = 0; r < block.row_count; ++r) {
          const std::size_t row = block.first_row + r;
          const std::size_t source = basis.order.empty() ? row : 3 * std::size_t(basis.order[row / 3]) + row % 3;
          visit(source, block.columns[c], block.values[c * block.row_count + r]);
        }
  }

  const FaceModel& model_;
  const bake::FloatFace face_;
  const std::size_t first_;
  Eigen::MatrixXf shapes_;
  Eigen::LDLT<Eigen::MatrixXd> products_;
};

}  // namespace fb::bench
