// Controls found for targets: factorisations and bounded minima against their definitions, poses that are found again,
// what preferences do, and that nothing is allocated meanwhile.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory_resource>
#include <numeric>

#include "joint_reference.h"
#include "runtime/float_mode.h"
#include "runtime/instruction_set.h"
#include "runtime/solve/pose_solver.h"
#include "test_models.h"

namespace test_pose_solver {

using namespace fb;
using namespace fb::runtime;

namespace {

using Controls = std::vector<float>;

// B^T B + `ridge`, of random B.
std::vector<double> random_matrix(Random& random, std::size_t count, double ridge) {
  std::vector<double> b(count * count), matrix(count * count);
  for (double& value : b) value = random.uniform(-1, 1);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t k = 0; k < count; ++k) matrix[i * count + j] += b[k * count + i] * b[k * count + j];
      if (i == j) matrix[i * count + j] += ridge;
    }
  return matrix;
}

TEST_CASE("systems of any size are solved, and the diagonals of their inverses found") {
  Random random(1);
  for (const std::size_t count : {1u, 2u, 15u, 16u, 17u, 31u, 48u, 75u}) {
    const std::vector<double> matrix = random_matrix(random, count, 0.5);
    Cholesky factor(80, choose_kernels(), *std::pmr::get_default_resource());
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = i; j < count; ++j)
        factor.matrix()[i * factor.row_stride() + j] = static_cast<float>(matrix[i * count + j]);
    REQUIRE(factor.factorise(count));
    std::vector<float> x(factor.row_stride()), wanted(count), diagonal(count), work(factor.row_stride());
    for (float& value : wanted) value = random.uniform(-1, 1);
    for (std::size_t i = 0; i < count; ++i) {
      double sum = 0;
      for (std::size_t j = 0; j < count; ++j) sum += matrix[i * count + j] * wanted[j];
      x[i] = static_cast<float>(sum);
    }
    factor.solve(x.data());
    for (std::size_t i = 0; i < count; ++i) CHECK(x[i] == doctest::Approx(wanted[i]).epsilon(1e-3).scale(1));
    factor.inverse_diagonal(diagonal.data(), work.data());
    for (std::size_t c = 0; c < count; ++c) {
      std::fill(x.begin(), x.end(), 0.0f);
      x[c] = 1;
      factor.solve(x.data());
      CHECK(diagonal[c] == doctest::Approx(x[c]).epsilon(1e-3));
    }
  }
}

TEST_CASE("what is not positive definite is refused") {
  Cholesky factor(20, choose_kernels(), *std::pmr::get_default_resource());
  for (const float last : {-1.0f, 0.0f, NAN, INFINITY}) {
    for (std::size_t i = 0; i < 18; ++i)
      for (std::size_t j = i; j < 18; ++j) factor.matrix()[i * factor.row_stride() + j] = i == j ? 1.0f : 0.0f;
    factor.matrix()[17 * factor.row_stride() + 17] = last;
    CHECK(!factor.factorise(18));
  }
}

TEST_CASE("bounded minima fulfil the conditions of a minimum") {
  Random random(2);
  for (const std::size_t count : {1u, 5u, 40u, 90u}) {
    BoxMinimum box(96, choose_kernels(), *std::pmr::get_default_resource());
    for (int again = 0; again < 5; ++again) {
      const std::vector<double> matrix = random_matrix(random, count, 0.05);
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j <= i; ++j)
          box.matrix()[i * box.row_stride() + j] = static_cast<float>(matrix[i * count + j]);
        box.gradient()[i] = random.uniform(-4, 4);
        box.lower()[i] = random.uniform() < 0.3f ? 0.0f : random.uniform(-1, 0);
        box.upper()[i] = random.uniform() < 0.3f && box.lower()[i] < 0 ? 0.0f : random.uniform(0, 1);
      }
      box.set_matrix(count, 0);
      REQUIRE(box.solve());
      double value = 0;
      for (std::size_t i = 0; i < count; ++i) {
        double slope = box.gradient()[i];
        for (std::size_t j = 0; j < count; ++j) slope += matrix[i * count + j] * box.step()[j];
        value += box.step()[i] * (0.5 * slope + 0.5 * box.gradient()[i]);
        const double little = 2e-3 * (1 + matrix[i * count + i]);
        CHECK(box.step()[i] >= box.lower()[i]);
        CHECK(box.step()[i] <= box.upper()[i]);
        if (box.step()[i] > box.lower()[i]) CHECK(slope < little);
        if (box.step()[i] < box.upper()[i]) CHECK(slope > -little);
      }
      CHECK(box.decrease() == doctest::Approx(-value).epsilon(1e-3).scale(1));
    }
  }
}

std::vector<WeightedPoint> all_vertices(const Evaluator& face) {
  std::vector<WeightedPoint> points;
  for (std::uint32_t v = 0; v < face.vertex_count(); ++v) points.push_back({{v, 0, 0}, {1, 0, 0}});
  return points;
}

// Of the points, in the order of `points`, whose vertices are in baked order.
std::vector<float> positions_of(const Evaluator& face, const Controls& pose) {
  Workspace workspace(face);
  std::vector<float> all(3 * face.vertex_count()), baked(all.size());
  face.evaluate(pose.data(), all.data(), workspace);
  const auto& order = face.layout().order;
  for (std::size_t i = 0; i < face.vertex_count(); ++i)
    std::copy_n(&all[3 * (order.empty() ? i : order[i])], 3, &baked[3 * i]);
  return baked;
}

SolvePreferences exactly() {
  SolvePreferences preferences;
  preferences.noise = 1e-3;
  preferences.most_iterations = 60;
  preferences.tolerance = 1e-6f;
  return preferences;
}

SolveResult solve(PoseSolver& solver, const SolveTargets& targets, const SolvePreferences& preferences,
                  Controls& controls, RigidMotion& motion) {
  SolveResult result;
  with_float_mode([&] { result = solver.solve(targets, preferences, controls.data(), motion); });
  return result;
}

double worst_difference(const Evaluator& face, const Controls& a, const Controls& b) {
  const std::vector<float> first = positions_of(face, a), second = positions_of(face, b);
  double worst = 0;
  for (std::size_t i = 0; i < first.size(); ++i) worst = std::max(worst, std::fabs(double(first[i]) - second[i]));
  return worst;
}

TEST_CASE("a pose whose vertices are given is found again") {
  Random random(3);
  for (std::uint64_t seed = 1; seed < 4; ++seed) {
    for (const PackedModel& model : {tiny_packed_model(seed), exact_model(seed), gentle_model()}) {
      const Evaluator face(model);
      const std::vector<WeightedPoint> points = all_vertices(face);
      PoseSolver solver(face, {.points = points}, {}, *std::pmr::get_default_resource());
      int found = 0;
      for (int i = 0; i < 8; ++i) {
        const Controls pose = random_pose(model.schema, random);
        const std::vector<float> targets = positions_of(face, pose);
        Controls controls = pose;  // nearby, as in a clip
        for (std::size_t c = 0; c < controls.size(); ++c)
          controls[c] += 0.1f * (model.schema.controls[c].rest - pose[c]);
        RigidMotion motion;
        solve(solver, {.points = targets.data()}, exactly(), controls, motion);
        found += worst_difference(face, pose, controls) < 5e-3;
      }
      CHECK(found >= 7);  // bends may end in another minimum
    }
  }
}

TEST_CASE("controls stay in their ranges, and those that are locked where they are") {
  const PackedModel model = tiny_packed_model(2);
  const Evaluator face(model);
  const std::vector<WeightedPoint> points = all_vertices(face);
  PoseSolver solver(face, {.points = points}, {}, *std::pmr::get_default_resource());
  std::vector<float> targets = positions_of(face, model.schema.rest_pose());
  Random random(5);
  for (float& target : targets) target += random.uniform(-20, 20);  // nothing that the face can do
  SolvePreferences preferences = exactly();
  const std::vector<std::uint8_t> movable = {1, 0, 1, 1, 1};
  preferences.movable = movable.data();
  Controls controls = model.schema.rest_pose();
  controls[1] = 0.375f;
  RigidMotion motion;
  const SolveResult result = solve(solver, {.points = targets.data()}, preferences, controls, motion);
  CHECK(std::isfinite(result.objective));
  CHECK(controls[1] == 0.375f);
  for (std::size_t c = 0; c < controls.size(); ++c) {
    CHECK(controls[c] >= model.schema.controls[c].minimum);
    CHECK(controls[c] <= model.schema.controls[c].maximum);
  }
}

TEST_CASE("without targets, preferences alone decide") {
  const PackedModel model = tiny_packed_model(2);
  const Evaluator face(model);
  const std::vector<WeightedPoint> points = all_vertices(face);
  PoseSolver solver(face, {.points = points}, {}, *std::pmr::get_default_resource());
  Controls near = {0.5f, -0.5f, 0.75f, 0.5f, 0.25f}, controls = model.schema.rest_pose();
  RigidMotion motion;
  SolvePreferences preferences = exactly();
  preferences.nearness = 1;
  preferences.near = near.data();
  solve(solver, {}, preferences, controls, motion);
  for (std::size_t c = 0; c < near.size(); ++c) CHECK(controls[c] == doctest::Approx(near[c]).epsilon(1e-3).scale(1));
  preferences.sparsity = 100;
  solve(solver, {}, preferences, controls, motion);
  CHECK(controls == model.schema.rest_pose());
}

TEST_CASE("smoothness holds what was before, symmetry what the other side does") {
  PackedModel model = tiny_packed_model(3);
  model.schema.controls[0].labels.mirror = "lid_close";
  model.schema.controls[3].labels.mirror = "jaw_open";
  const Evaluator face(model);
  const std::vector<WeightedPoint> points = all_vertices(face);
  PoseSolver solver(face, {.points = points}, {}, *std::pmr::get_default_resource());
  SolvePreferences preferences = exactly();
  RigidMotion motion;
  const Controls before = {0.5f, 0.25f, 0.5f, 1.5f, 0.5f};
  Controls controls = model.schema.rest_pose();
  preferences.smoothness = 5;
  preferences.before = before.data();
  solve(solver, {}, preferences, controls, motion);
  for (std::size_t c = 0; c < before.size(); ++c)
    CHECK(controls[c] == doctest::Approx(before[c]).epsilon(1e-2).scale(1));
  preferences.symmetry = 1e4f;
  solve(solver, {}, preferences, controls, motion);
  CHECK(controls[0] == doctest::Approx(controls[3] / 2).epsilon(1e-2));  // shares of ranges
  CHECK(controls[0] == doctest::Approx(0.625f).epsilon(2e-2));
}

TEST_CASE("a rigid motion of the head is found with the pose") {
  const PackedModel model = tiny_packed_model(1);
  const Evaluator face(model);
  const std::vector<WeightedPoint> points = all_vertices(face);
  PoseSolver solver(face, {.points = points}, {}, *std::pmr::get_default_resource());
  const Controls pose = {0.25f, 0.125f, 0.5f, 0.75f, 0.25f};
  RigidMotion truth = RigidMotion().after({0.3, -0.2, 0.4}, {0, 0, 0}).after({0.1, 0, 0.2}, {1, -2, 0.5});
  std::vector<float> targets = positions_of(face, pose);
  const std::array<double, 9> r = truth.matrix();
  for (std::size_t i = 0; i < targets.size(); i += 3) {
    const double p[3] = {targets[i], targets[i + 1], targets[i + 2]};
    for (std::size_t a = 0; a < 3; ++a)
      targets[i + a] =
          static_cast<float>(r[3 * a] * p[0] + r[3 * a + 1] * p[1] + r[3 * a + 2] * p[2] + truth.translation[a]);
  }
  SolvePreferences preferences = exactly();
  preferences.find_motion = true;
  Controls controls = pose;  // nearby: poses bend so much that there are other minima
  for (std::size_t c = 0; c < pose.size(); ++c) controls[c] += 0.2f * (model.schema.controls[c].rest - pose[c]);
  RigidMotion motion;
  solve(solver, {.points = targets.data()}, preferences, controls, motion);
  CHECK(worst_difference(face, pose, controls) < 5e-3);
  for (std::size_t a = 0; a < 3; ++a)
    CHECK(motion.translation[a] == doctest::Approx(truth.translation[a]).epsilon(5e-3));
  const std::array<double, 9> found = motion.matrix();
  for (std::size_t i = 0; i < 9; ++i) CHECK(found[i] == doctest::Approx(r[i]).epsilon(5e-3).scale(1));
}

TEST_CASE("distances and frames are targets, too") {
  const PackedModel model = gentle_model();
  const Evaluator face(model);
  const std::vector<WeightedPoint> points = all_vertices(face);
  std::vector<PointPair> pairs;
  for (std::uint32_t v = 0; v + 13 < points.size(); ++v) pairs.push_back({v, v + 13});
  std::vector<std::uint32_t> sockets(face.socket_count()), joints(face.joint_count());
  std::iota(sockets.begin(), sockets.end(), 0u);
  std::iota(joints.begin(), joints.end(), 0u);
  PoseSolver solver(face, {points, sockets, joints}, pairs, *std::pmr::get_default_resource());
  Random random(6);
  int by_distances = 0, by_frames = 0;
  for (int i = 0; i < 6; ++i) {
    Controls pose = random_pose(model.schema, random);
    for (std::size_t c = 0; c < pose.size(); ++c) pose[c] += 0.5f * (model.schema.controls[c].rest - pose[c]);
    PoseDerivative derivative(face, {points, sockets, joints}, *std::pmr::get_default_resource());
    with_float_mode([&] { derivative.find_positions(pose.data()); });
    const std::vector<float> at = positions_of(face, pose);
    std::vector<float> distances;
    for (const PointPair& pair : pairs) {
      double squares = 0;
      for (std::size_t a = 0; a < 3; ++a) squares += std::pow(at[3 * pair.first + a] - at[3 * pair.second + a], 2);
      distances.push_back(static_cast<float>(std::sqrt(squares)));
    }
    for (const bool frames : {false, true}) {
      SolveTargets targets;
      (frames ? targets.frames : targets.distances) = frames ? derivative.frames().frames() : distances.data();
      Controls controls = pose;
      for (std::size_t c = 0; c < pose.size(); ++c) controls[c] += 0.1f * (model.schema.controls[c].rest - pose[c]);
      RigidMotion motion;
      solve(solver, targets, exactly(), controls, motion);
      (frames ? by_frames : by_distances) += worst_difference(face, pose, controls) < 0.03;
    }
  }
  CHECK(by_distances >= 5);
  CHECK(by_frames >= 5);
}

TEST_CASE("controls that targets do not decide are told apart") {
  PackedModel model = tiny_packed_model(1);
  const Evaluator face(model);
  const std::vector<WeightedPoint> points = all_vertices(face);
  PoseSolver solver(face, {.points = points}, {}, *std::pmr::get_default_resource());
  const Controls pose = {0.5f, 0.5f, 0.75f, 1, 0.5f};
  std::vector<float> targets = positions_of(face, pose), decided(pose.size()), weights(points.size(), 0.0f);
  SolvePreferences preferences = exactly();
  preferences.nearness = 1;
  Controls controls = pose;
  RigidMotion motion;
  solve(solver, {.points = targets.data()}, preferences, controls, motion);
  with_float_mode([&] { solver.find_decided(preferences, decided.data()); });
  for (const float share : decided) CHECK(share > 0.9f);
  solve(solver, {.points = targets.data(), .point_weights = weights.data()}, preferences, controls, motion);
  with_float_mode([&] { solver.find_decided(preferences, decided.data()); });
  for (const float share : decided) CHECK(share == doctest::Approx(0).scale(1).epsilon(1e-4));
}

// Counts what is allocated once it is told to.
class CountedMemory final : public std::pmr::memory_resource {
 public:
  bool counting = false;
  std::size_t count = 0;

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    count += counting;
    return std::pmr::new_delete_resource()->allocate(bytes, alignment);
  }
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
    std::pmr::new_delete_resource()->deallocate(memory, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }
};

TEST_CASE("every instruction set gives the same bits, and nothing is allocated") {
  const PackedModel model = gentle_model();
  Random random(7);
  const Controls pose = random_pose(model.schema, random);
  Controls expected;
  for (const PoseKernels* kernels : runnable_kernels()) {
    const Evaluator face(model, {}, *kernels);
    const std::vector<WeightedPoint> points = all_vertices(face);
    CountedMemory memory;
    PoseSolver solver(face, {.points = points}, {}, memory);
    const std::vector<float> targets = positions_of(face, pose);
    memory.counting = true;
    SolvePreferences preferences = exactly();
    preferences.sparsity = 0.5f;
    preferences.find_motion = true;
    Controls controls = model.schema.rest_pose();
    RigidMotion motion;
    solve(solver, {.points = targets.data()}, preferences, controls, motion);
    CHECK(memory.count == 0);
    if (expected.empty()) expected = controls;
    CHECK(std::memcmp(controls.data(), expected.data(), 4 * controls.size()) == 0);
  }
}

}  // namespace

}  // namespace test_pose_solver
