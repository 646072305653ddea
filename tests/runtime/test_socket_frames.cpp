// Frames of sockets: they follow rigid motions exactly, and deformations as the best fit does.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

#include "runtime/socket_frames.h"
#include "test_models.h"

namespace test_socket_frames {

using namespace fb;
using namespace fb::runtime;

namespace {

using Rotation = Eigen::Matrix3d;
using SocketFrame = std::array<float, 12>;
using Rows = Eigen::Map<const Eigen::Matrix<float, 3, 4, Eigen::RowMajor>>;

const std::vector<std::uint32_t> vertices = {3, 9, 10, 17, 22, 28};
const std::vector<float> weights = {1, 2, 0.5f, 1, 3, 1};
const SocketFrame at_rest = {0, -1, 0, 2, 1, 0, 0, 1.5f, 0, 0, 1, 1};

PackedModel model_with_socket() {
  PackedModel model = tiny_packed_model();
  model.order.clear();
  model.character.sockets = {{"one", vertices, weights, at_rest}};
  return model;
}

SocketFrame frame_of(const PackedModel& model, const std::vector<float>& points) {
  const SocketFrames sockets(model, {}, *std::pmr::get_default_resource());
  SocketFrame frame;
  sockets.run(points.data(), {}, frame.data());
  return frame;
}

Eigen::Vector3d point(const std::vector<float>& points, std::uint32_t v) {
  return Eigen::Vector3f(&points[3 * v]).cast<double>();
}

void set_point(std::vector<float>& points, std::uint32_t v, const Eigen::Vector3d& to) {
  for (int axis = 0; axis < 3; ++axis) points[3 * v + axis] = static_cast<float>(to[axis]);
}

// The best rigid fit by singular value decomposition (Kabsch).
Eigen::Matrix<double, 3, 4> best_fit(const std::vector<float>& rest, const std::vector<float>& posed) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), q = p;
  double sum = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    p += weights[i] * point(rest, vertices[i]);
    q += weights[i] * point(posed, vertices[i]);
    sum += weights[i];
  }
  p /= sum, q /= sum;
  Eigen::Matrix3d s = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < vertices.size(); ++i)
    s += weights[i] * (point(posed, vertices[i]) - q) * (point(rest, vertices[i]) - p).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(s, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  const Rotation r = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  const Eigen::Matrix<double, 3, 4> frame = Rows(at_rest.data()).cast<double>();
  Eigen::Matrix<double, 3, 4> moved = r * frame;
  moved.col(3) = r * (frame.col(3) - p) + q;
  return moved;
}

double difference(const SocketFrame& a, const Eigen::Matrix<double, 3, 4>& b) {
  return (Rows(a.data()).cast<double>() - b).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("a frame is exact at rest") {
  const PackedModel model = model_with_socket();
  CHECK(frame_of(model, model.rest.points) == at_rest);
}

TEST_CASE("a frame follows every rotation and translation") {
  const PackedModel model = model_with_socket();
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d axis = Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const double angle = trial < 5 ? M_PI : random.uniform(-3.1f, 3.1f);
    const Rotation r = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    const Eigen::Vector3d shift(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9));
    std::vector<float> posed = model.rest.points;
    for (std::uint32_t v = 0; v < posed.size() / 3; ++v) set_point(posed, v, r * point(model.rest.points, v) + shift);
    Eigen::Matrix<double, 3, 4> expected = r * Rows(at_rest.data()).cast<double>();
    expected.col(3) += shift;
    CHECK(difference(frame_of(model, posed), expected) < 1e-5);
  }
}

TEST_CASE("a frame is the best rigid fit of a deformed surface") {
  const PackedModel model = model_with_socket();
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<float> posed = model.rest.points;
    for (float& x : posed) x += random.uniform(-0.5f, 0.5f);
    CHECK(difference(frame_of(model, posed), best_fit(model.rest.points, posed)) < 1e-5);
  }
}

TEST_CASE("vertices on a plane and on almost a line have a best fit, too") {
  PackedModel model = model_with_socket();
  for (const float width : {1.0f, 3e-3f}) {
    for (std::size_t v = 0; v < model.rest.vertex_count(); ++v) {
      model.rest.points[3 * v + 1] = width * float(v / 6);
      model.rest.points[3 * v + 2] = 0;
    }
    const Rotation r = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    std::vector<float> posed = model.rest.points;
    for (std::uint32_t v = 0; v < posed.size() / 3; ++v) set_point(posed, v, r * point(model.rest.points, v));
    CHECK(difference(frame_of(model, posed), best_fit(model.rest.points, posed)) < 1e-3);
  }
}

TEST_CASE("a frame of collapsed vertices does not turn, and one of infinite ones stays") {
  const PackedModel model = model_with_socket();
  std::vector<float> posed(model.rest.points.size(), 2.0f);
  const SocketFrame frame = frame_of(model, posed);
  for (const std::size_t i : {0u, 1u, 2u, 4u, 5u, 6u, 8u, 9u, 10u}) CHECK(frame[i] == at_rest[i]);
  posed[3 * vertices[0]] = INFINITY;
  CHECK(frame_of(model, posed) == at_rest);
  posed[3 * vertices[0]] = NAN;
  CHECK(frame_of(model, posed) == at_rest);
}

}  // namespace test_socket_frames
