// Derivatives of points by controls: against differences of an evaluation in double precision that rounds nothing, and
// of poses of the runtime; with every kernel, at levels of detail, in every kind of feature.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "joint_reference.h"
#include "runtime/derivative/pose_derivative.h"
#include "runtime/float_mode.h"
#include "runtime/instruction_set.h"
#include "test_models.h"

namespace test_pose_derivative {

using namespace fb;
using namespace fb::runtime;

namespace {

using Reals = std::vector<double>;
using Controls = std::vector<float>;

// What a model evaluates to, without rounding.
class RealFace {
 public:
  explicit RealFace(const PackedModel& model, float lod = 0) : model_(model), face_(model), lod_(lod) {}

  // Positions of the surface, as the driven joints move it.
  Reals positions(const Reals& controls) const {
    const Reals points = unskinned(clamped(controls));
    return model_.rest.driven.empty() ? Reals(points.begin(), points.begin() + std::ptrdiff_t(3 * surface()))
                                      : reference_positions(model_.rest, points);
  }
  // Frames of all sockets, then of all driven joints.
  Reals frames(const Reals& controls) const {
    const Reals vertices = positions(controls);
    const SocketFrames& sockets = face_.layout().sockets;
    const auto& order = face_.layout().order;
    Reals numbers;
    for (std::size_t s = 0; s < sockets.count(); ++s) {
      const SocketFrames::Socket& socket = sockets.socket(s);
      const SocketFrames::Fit fit = sockets.fit(socket, [&](std::size_t point) {
        const std::uint32_t index = sockets.points(socket)[point].index;
        return &vertices[3 * (order.empty() ? index : order[index])];
      });
      for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column) {
          double sum = column == 3 ? fit.centre[row] : 0;
          for (std::size_t a = 0; a < 3; ++a)
            sum += fit.rotation[row][a] * (socket.frame[4 * a + column] - (column == 3 ? socket.centre[a] : 0));
          numbers.push_back(sum);
        }
    }
    if (!model_.rest.driven.empty())
      for (const Frame<double>& frame : reference_frames(model_.rest, unskinned(clamped(controls))))
        numbers.insert(numbers.end(), frame.begin(), frame.end());
    return numbers;
  }
  const Evaluator& evaluator() const { return face_; }
  std::size_t surface() const { return model_.rest.surface_vertex_count(); }

 private:
  Reals clamped(Reals controls) const {
    for (std::size_t c = 0; c < controls.size(); ++c)
      controls[c] =
          std::clamp<double>(controls[c], model_.schema.controls[c].minimum, model_.schema.controls[c].maximum);
    return controls;
  }
  Reals features(const Reals& controls) const {
    Reals values;
    for (const Feature& f : model_.features) {
      if (f.of_features()) {
        const double a = values[f.first], b = values[f.second];
        values.push_back(f.kind == Feature::Kind::product ? a * b : std::min(a, b));
        continue;
      }
      const double u = (controls[f.control] - model_.schema.controls[f.control].rest) * f.scale, t = u - f.threshold;
      values.push_back(f.kind == Feature::Kind::identity ? u
                       : f.kind == Feature::Kind::ramp   ? std::max(t, 0.0)
                                                         : std::max(std::min(t, 1 + (1 - t) * f.fall), 0.0));
    }
    return values;
  }
  static Reals layer_of(const PackedLayer& layer, const Reals& x) {
    Reals y;
    for (std::uint32_t o = 0; o < layer.outputs; ++o) {
      double sum = layer.bias[o];
      for (std::uint32_t i = 0; i < layer.inputs; ++i)
        sum += double(layer.scales[o]) * layer.weights[std::size_t(o) * layer.inputs + i] * x[i];
      if (layer.activation == Activation::relu) sum = std::max(sum, 0.0);
      if (layer.activation == Activation::tanh) sum = std::tanh(sum);
      if (layer.activation == Activation::silu) sum = sum / (1 + std::exp(-sum));
      y.push_back(layer.skip ? sum + x[o] : sum);
    }
    return y;
  }
  Reals coefficients(const Reals& controls) const {
    const Reals all = features(controls);
    Reals values;
    for (const std::uint32_t f : model_.direct) values.push_back(all[f]);
    for (const PackedRegion& region : model_.regions) {
      Reals x, rest(region.features.size());
      for (const std::uint32_t f : region.features) x.push_back(all[f]);
      const bool active = std::any_of(x.begin(), x.end(), [](double v) { return v != 0; });
      double sum = 0, largest = 0;
      for (const std::uint32_t f : region.gate.features) {
        sum += std::fabs(all[f]);
        largest = std::max(largest, std::fabs(all[f]));
      }
      const double gate = region.gate.features.empty() ? 1 : std::clamp(region.gate.slope * (sum - largest), 0.0, 1.0);
      for (const PackedLayer& layer : region.layers) {
        x = layer_of(layer, x);
        rest = layer_of(layer, rest);
      }
      for (std::size_t k = 0; k < x.size(); ++k) values.push_back(active ? gate * (x[k] - rest[k]) : 0);
    }
    return values;
  }
  Reals weights_of_exact_poses(const Reals& controls) const {
    Reals weights;
    double sum = 0;
    for (const ExactPose& pose : model_.exact) {
      double squares = 0;
      for (std::size_t c = 0; c < controls.size(); ++c) {
        const Control& control = model_.schema.controls[c];
        const double length = double(control.maximum) - control.minimum;
        squares += std::pow((controls[c] - pose.controls[c]) / length, 2);
      }
      const double near = std::max(1 - squares * pose.falloff, 0.0);
      weights.push_back(near * near);
      sum += weights.back();
    }
    for (double& weight : weights) weight /= std::max(sum, 1.0);
    return weights;
  }
  // In the source's order.
  Reals unskinned(const Reals& controls) const {
    const DetailChoice choice(face_.layout().details, lod_);
    const Reals values = coefficients(controls), exact = weights_of_exact_poses(controls);
    Reals rows(model_.rest.points.size());  // in baked order
    for (std::size_t row = 0; row < rows.size(); ++row) {
      rows[row] = model_.rest.points[model_.coordinate(static_cast<std::uint32_t>(row))];
      for (std::size_t e = 0; e < exact.size(); ++e)
        rows[row] += exact[e] * model_.exact[e].step * model_.exact[e].values[row];
    }
    for (const PackedRowBlock& block : model_.row_blocks)
      for (std::size_t c = 0; c < block.columns.size(); ++c) {
        const std::uint32_t column = block.columns[c].column;
        const double factor = choice.level && !choice.level->uses(column) ? 0
                              : choice.next && !choice.next->uses(column) ? 1 - choice.share
                                                                          : 1;
        for (std::uint32_t r = 0; r < block.row_count; ++r)
          rows[block.first_row + r] +=
              factor * values[column] * block.columns[c].scale * block.values[c * block.row_count + r];
      }
    slide(choice, rows);
    Reals points(rows.size());
    for (std::uint32_t row = 0; row < rows.size(); ++row) points[model_.coordinate(row)] = rows[row];
    return points;
  }
  void slide(const DetailChoice& choice, Reals& rows) const {
    const DetailLayout& details = face_.layout().details;
    if (!choice.level && !choice.next) return;
    const std::uint32_t last = details.levels.back().vertices;
    const auto of_level = choice.level ? choice.level->vertices : static_cast<std::uint32_t>(surface());
    for (std::uint32_t v = choice.next ? choice.next->vertices : of_level; v < surface(); ++v)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double target = 0;
        for (std::size_t k = 0; k < 3; ++k)
          target += details.points[v - last].weights[k] * rows[3 * details.points[v - last].corners[k] + axis];
        double& at = rows[3 * v + axis];
        at += (v < of_level ? double(choice.share) : 1.0) * (target - at);
      }
  }

  const PackedModel& model_;
  Evaluator face_;
  float lod_;
};

// All vertices, then sums of three, in the source's order; see baked().
std::vector<WeightedPoint> some_points(std::size_t vertices) {
  std::vector<WeightedPoint> points;
  for (std::uint32_t v = 0; v < vertices; ++v) points.push_back({{v, 0, 0}, {1, 0, 0}});
  for (std::uint32_t v = 0; v + 11 < vertices; v += 3) points.push_back({{v, v + 11, v + 4}, {0.5f, 0.25f, 0.25f}});
  points.push_back({{3, 3, 7}, {0.75f, 0.5f, 0}});  // twice the same, not one in all
  return points;
}

std::vector<WeightedPoint> baked(const Evaluator& face, std::vector<WeightedPoint> points) {
  const auto& index = face.layout().baked_index;
  for (WeightedPoint& point : points)
    for (std::uint32_t& vertex : point.vertices) vertex = index.empty() ? vertex : index[vertex];
  return points;
}

struct Found {
  std::vector<float> positions, derivatives;  // points x 3, then frames x 12; these x controls
};

std::vector<std::uint32_t> all_of(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  return numbers;
}

Found find(const Evaluator& face, const std::vector<WeightedPoint>& points, const Controls& controls, float lod,
           bool downwards = false) {
  const std::vector<WeightedPoint> of = baked(face, points);
  const std::vector<std::uint32_t> sockets = all_of(face.socket_count()), joints = all_of(face.joint_count());
  PoseDerivative derivative(face, {of, sockets, joints, lod}, *std::pmr::get_default_resource());
  const std::vector<std::uint8_t> sides(controls.size(), downwards);
  with_float_mode([&] { derivative.run(controls.data(), sides.data()); });
  const std::size_t frames = 12 * (sockets.size() + joints.size()), rows = 3 * points.size() + frames;
  Found found{std::vector<float>(rows), std::vector<float>(rows * controls.size())};
  for (std::size_t p = 0; p < points.size(); ++p)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const PointGroup& group = derivative.groups()[derivative.place(p).group];
      const std::size_t row = 3 * p + axis, at = axis * group.stride() + derivative.place(p).slot;
      found.positions[row] = group.positions()[at];
      for (std::size_t c = 0; c < group.controls().size(); ++c)
        found.derivatives[row * controls.size() + group.controls()[c]] = group.by_control(c)[at];
    }
  for (std::size_t i = 0; i < frames; ++i) {
    const std::size_t row = 3 * points.size() + i;
    found.positions[row] = derivative.frames().frames()[i];
    for (std::size_t c = 0; c < controls.size(); ++c)
      found.derivatives[row * controls.size() + c] = derivative.frames().by_control(c)[i];
  }
  return found;
}

Reals positions_of(const RealFace& face, const std::vector<WeightedPoint>& points, const Reals& controls) {
  const Reals vertices = face.positions(controls);
  Reals positions;
  for (const WeightedPoint& point : points)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += point.weights[k] * vertices[3 * point.vertices[k] + axis];
      positions.push_back(sum);
    }
  const Reals frames = face.frames(controls);
  positions.insert(positions.end(), frames.begin(), frames.end());
  return positions;
}

// Of a control to the side to which it can move: the difference of positions over a small step, and as small a step
// again, which tells what the first one's error is.
void check_side(const PackedModel& model, const Controls& controls, float lod, bool downwards) {
  const RealFace real(model, lod);
  const std::vector<WeightedPoint> points = some_points(real.surface());
  const Found found = find(real.evaluator(), points, controls, lod, downwards);
  const Reals at(controls.begin(), controls.end()), positions = positions_of(real, points, at);
  const double scale = model.rest.diagonal();
  for (std::size_t i = 0; i < positions.size(); ++i)
    REQUIRE(std::fabs(found.positions[i] - positions[i]) < 4e-3 * scale);  // the runtime rounds
  for (std::size_t c = 0; c < controls.size(); ++c) {
    const Control& control = model.schema.controls[c];
    const bool down = downwards ? controls[c] > control.minimum : controls[c] >= control.maximum;
    const double step = down ? -1e-6 : 1e-6;
    Reals moved = at;
    moved[c] += step;
    const Reals there = positions_of(real, points, moved);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const double expected = (there[i] - positions[i]) / step;
      const double size = std::max(1.0, std::fabs(expected));
      CHECK_MESSAGE(std::fabs(found.derivatives[i * controls.size() + c] - expected) < 2e-4 * size, "control ", c,
                    " row ", i, ": ", found.derivatives[i * controls.size() + c], " for ", expected);
    }
  }
}

void check_pose(const PackedModel& model, const Controls& controls, float lod) {
  for (const bool downwards : {false, true}) check_side(model, controls, lod, downwards);
}

void check_model(const PackedModel& model, std::uint64_t seed, float lod = 0) {
  Random random(seed, 9);
  check_pose(model, model.schema.rest_pose(), lod);
  for (int i = 0; i < 6; ++i) {
    Controls pose = random_pose(model.schema, random);
    for (std::size_t c = 0; c < pose.size(); ++c)  // some at rest, some at the ends of their ranges
      if (random.uniform() < 0.4f)
        pose[c] = i % 3 == 0   ? model.schema.controls[c].rest
                  : i % 3 == 1 ? model.schema.controls[c].maximum
                               : model.schema.controls[c].minimum;
    check_pose(model, pose, lod);
  }
}

TEST_CASE("derivatives are those of an evaluation that rounds nothing") {
  for (std::uint64_t seed = 1; seed < 5; ++seed) check_model(tiny_packed_model(seed), seed);
}

TEST_CASE("exact poses, driven joints and levels of detail count") {
  check_model(exact_model(2), 1);
  PackedModel gentle = gentle_model();
  check_model(gentle, 2);
  for (const float lod : {0.25f, 1.0f, 1.5f, 2.0f}) check_model(gentle, 3, lod);
}

TEST_CASE("near an exact pose, its weight changes with the controls") {
  const PackedModel model = exact_model(3);
  for (const ExactPose& exact : model.exact) {
    Controls pose = exact.controls;
    for (std::size_t c = 0; c < pose.size(); ++c) pose[c] += 0.02f * (model.schema.controls[c].rest - pose[c]);
    check_pose(model, pose, 0);
  }
}

TEST_CASE("controls out of range move nothing") {
  const PackedModel model = tiny_packed_model();
  const Evaluator face(model);
  Controls pose = model.schema.rest_pose();
  pose[0] = 2;
  pose[1] = -7;
  const std::vector<WeightedPoint> points = some_points(face.vertex_count());
  const Found found = find(face, points, pose, 0);
  for (std::size_t row = 0; row < 3 * points.size(); ++row)
    for (std::size_t c = 0; c < 2; ++c) CHECK(found.derivatives[row * pose.size() + c] == 0);
}

TEST_CASE("every instruction set gives the same bits, alone or again") {
  const PackedModel model = gentle_model();
  Random random(4);
  const Controls pose = random_pose(model.schema, random);
  Found expected;
  for (const PoseKernels* kernels : runnable_kernels()) {
    const Evaluator face(model, {}, *kernels);
    const std::vector<WeightedPoint> points = some_points(face.vertex_count());
    const Found found = find(face, points, pose, 0.5f);
    if (expected.positions.empty()) expected = found;
    CHECK(std::memcmp(found.positions.data(), expected.positions.data(), 4 * found.positions.size()) == 0);
    CHECK(std::memcmp(found.derivatives.data(), expected.derivatives.data(), 4 * found.derivatives.size()) == 0);
  }
}

// The tiny model's networks have few outputs: a network is followed from them where many points are wanted, and from
// the points where few are.
TEST_CASE("derivatives do not depend on which other points are wanted") {
  const PackedModel model = tiny_packed_model(6);
  const Evaluator face(model);
  Random random(8);
  const Controls pose = random_pose(model.schema, random);
  const std::vector<WeightedPoint> points = some_points(face.vertex_count());
  const Found all = find(face, points, pose, 0);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Found one = find(face, {points[p]}, pose, 0);
    for (std::size_t i = 0; i < 3 * pose.size(); ++i)
      CHECK(one.derivatives[i] == doctest::Approx(all.derivatives[3 * p * pose.size() + i]).epsilon(1e-4).scale(1));
  }
}

}  // namespace

}  // namespace test_pose_derivative
