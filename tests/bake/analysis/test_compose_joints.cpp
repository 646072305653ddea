// How controls act on driven joints one after the other is found, and numbers are sums over controls then.
#include "bake/analysis/live/compose_joints.h"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>

#include "bake/analysis/live/joint_order.h"
#include "bake/rig/driven_pose.h"
#include "bake/rig/random_pose.h"
#include "memory_source.h"

namespace test_compose_joints {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t controls = 10, side = 9;
constexpr AxisOrder euler_order = {2, 0, 1};

double from_zero(const Axis& v) {
  return std::sqrt(dot(v, v));
}

double apart(const Axis& a, const Axis& b) {
  return from_zero({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
}

// What control k turns the first joint by.
Axis turn(std::size_t k, const float* c) {
  const double angle = (k % 2 ? 0.3 : 0.8) * double(c[k]);
  return {angle * std::cos(double(k)), angle * std::sin(double(k)), angle * (double(k % 3) / 2 - 0.5)};
}

// Three joints side by side. "order" turns by what controls 7, 2, 5, 0 and 3 do, one after the other; "euler" by angles
// that controls 1, 4 and 6 add to; "pivot" turns by controls 8 and 9 about a point that control 6 moves: halfway by
// less than half.
struct Numbers {
  Axis order = {}, euler = {}, pivot = {}, moved = {};
};
Numbers numbers_of(const float* c) {
  Numbers n;
  for (const std::size_t k : {7u, 2u, 5u, 0u, 3u}) n.order = turned_further(n.order, turn(k, c));
  n.euler = from_euler_angles({0.6 * c[1] - 0.2 * c[6], 0.5 * c[4] + 0.1 * c[1], 0.7 * c[6] + 0.3 * c[4]}, euler_order);
  n.pivot = turned_further({0.9 * c[8], 0, 0}, {0, 0.6 * c[9], 0.2 * c[9]});
  const double far = 0.5 * std::fabs(double(c[6])) * double(c[6]);
  const Axis point = {0.2 * far, far, -0.5 * far};
  const Frame<double> rotation = rotation_about(n.pivot);
  for (std::size_t a = 0; a < 3; ++a)
    n.moved[a] = point[a] - dot({rotation[4 * a], rotation[4 * a + 1], rotation[4 * a + 2]}, point);
  return n;
}

MemorySource make_rig() {
  Mesh* mesh = nullptr;
  const auto driven = std::make_shared<Mesh>();
  MemorySource rig(
      controls, side,
      [driven](const float* c, std::span<float> points) {
        const std::size_t first = driven->first_joint_coordinate();
        const auto [order, euler, pivot, moved] = numbers_of(c);
        std::size_t at = 0;
        for (const Axis& three : {order, euler, pivot, moved})
          for (const double number : three) points[first + at] = float(number / driven->driven.scales[at]), ++at;
        std::vector<double> posed(driven->points.begin(), driven->points.begin() + std::ptrdiff_t(3 * side * side));
        add_driven_skin(*driven, joint_motions(driven->driven, points.subspan(first)), posed);
        std::ranges::copy(posed, points.begin());
      },
      true);
  mesh = &rig.edit_rest();
  for (const char* name : {"order", "euler", "pivot"}) {
    DrivenJoint joint{name};
    joint.numbers = joint.name == "pivot" ? joint_rotation | joint_translation : joint_rotation;
    joint.rest = {0, -1, 0, 1 + 3 * float(mesh->driven.joints.size()), 1, 0, 0, 1, 0, 0, 1, 0.5f};
    mesh->driven.joints.push_back(joint);
  }
  mesh->driven.skin.influences = 1;
  for (std::size_t v = 0; v < side * side; ++v) {
    mesh->driven.skin.joints.push_back(static_cast<std::uint16_t>(v % side / 3));
    mesh->driven.skin.weights.push_back(1);
  }
  add_joint_vertices(*mesh);
  *driven = *mesh;
  return rig;
}

std::vector<float> numbers_at(Source& source, std::span<const float> pose) {
  std::vector<float> points(source.rest().points.size());
  source.evaluate(pose, 1, points);
  const std::vector<float>& scales = source.rest().driven.scales;
  std::vector<float> numbers(points.begin() + std::ptrdiff_t(source.rest().first_joint_coordinate()), points.end());
  for (std::size_t n = 0; n < scales.size(); ++n) numbers[n] *= scales[n];
  numbers.resize(scales.size());
  return numbers;
}

// How far the numbers of dense poses are from the sums of those of their controls alone.
double beyond_sums(Source& source) {
  Random random(5);
  double worst = 0;
  for (int i = 0; i < 30; ++i) {
    std::vector<float> pose = random_pose(source.schema(), 0.7f, random), sum(source.rest().driven.scales.size());
    for (std::size_t c = 0; c < controls; ++c) {
      std::vector<float> single(controls);
      single[c] = pose[c];
      const std::vector<float> of_single = numbers_at(source, single);
      for (std::size_t n = 0; n < sum.size(); ++n) sum[n] += of_single[n];
    }
    const std::vector<float> together = numbers_at(source, pose);
    for (std::size_t n = 0; n < sum.size(); ++n) worst = std::max(worst, std::fabs(double(sum[n]) - together[n]));
  }
  return worst;
}

std::vector<JointComposition> compose(Source& source, int threads = 2) {
  RigEvaluator rig(source, {.threads = threads});
  return compose_joints(rig, 1e-4, silent_progress());
}

}  // namespace

TEST_CASE("euler angles of every order say their rotation") {
  Random random(3);
  for (const AxisOrder& order : axis_orders)
    for (int i = 0; i < 20; ++i) {
      Axis angles;
      for (double& angle : angles) angle = double(random.uniform(-1.4f, 1.4f));
      CHECK(apart(euler_angles(from_euler_angles(angles, order), order), angles) < 1e-12);
    }
  const Axis quarter = from_euler_angles({1.5707963267948966, 0, 0.3}, {0, 1, 2});
  CHECK(apart(quarter, turned_further({1.5707963267948966, 0, 0}, {0, 0, 0.3})) < 1e-12);
  CHECK(apart(turned_before(turned_further({0.1, 0.2, 0.3}, {-0.5, 0.4, 0}), {-0.5, 0.4, 0}), {0.1, 0.2, 0.3}) < 1e-12);
}

TEST_CASE("an order is cut into as few rotations as leave enough") {
  // 4 before 2 before 9 before 1; 2 and 9 turn about one axis, 4 and 1 about two others.
  const std::vector<std::uint32_t> order = {4, 2, 9, 1};
  std::vector<PairOfTurns> pairs;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t k = i + 1; k < order.size(); ++k) {
      const bool same = order[i] == 2 && order[k] == 9, first = order[i] < order[k];
      const double summed = same ? 0.001 : 1;
      pairs.push_back({std::min(order[i], order[k]), std::max(order[i], order[k]), summed, first ? 0.0 : 4 * summed,
                       first ? 4 * summed : 0.0});
    }
  using Rotations = std::vector<std::vector<std::uint32_t>>;
  const JointOrder found(pairs);
  CHECK(found.left() == 0);
  CHECK(found.rotations(0.01, 16) == Rotations{{4}, {2, 9}, {1}});
  CHECK(found.rotations(0, 16) == Rotations{{4}, {2}, {9}, {1}});
  CHECK(found.rotations(0, 2).size() == 2);
  CHECK(found.rotations(100, 16) == Rotations{{4, 2, 9, 1}});
}

TEST_CASE("joints turn by what controls do one after the other, and numbers are sums then") {
  MemorySource rig = make_rig();
  const std::vector<JointComposition> compositions = compose(rig);
  REQUIRE(compositions.size() == 3);
  CHECK(compositions[0].outer_rotations.size() == 4);
  CHECK(compositions[0].outer_rotations[3].at(0).control == 3);  // the last
  CHECK(compositions[0].pivot.empty());
  CHECK(compositions[1].outer_rotations.size() == 2);
  CHECK(compositions[2].outer_rotations.size() == 1);
  REQUIRE(compositions[2].pivot.size() == 1);
  CHECK(compositions[2].pivot[0].control == 6);

  ComposedSource composed(rig, compositions);
  const std::vector<DrivenJoint>& joints = composed.rest().driven.joints;
  CHECK(joints[1].outer_rotations == std::vector<std::uint8_t>{1u << euler_order[1], 1u << euler_order[2]});
  CHECK((joints[2].numbers & joint_pivot) == joint_pivot);
  CHECK(composed.version() != rig.version());
  CHECK(beyond_sums(rig) > 0.1);
  CHECK(beyond_sums(composed) < 0.03);  // what straight lines leave of the way of a pivot

  // Joints move as they did.
  Random random(7);
  for (int i = 0; i < 20; ++i) {
    const std::vector<float> pose = random_pose(rig.schema(), 0.7f, random);
    std::vector<float> before(rig.rest().points.size()), now(composed.rest().points.size());
    rig.evaluate(pose, 1, before);
    composed.evaluate(pose, 1, now);
    CHECK(std::equal(before.begin(), before.begin() + std::ptrdiff_t(3 * side * side), now.begin()));
    const auto of = [](const Source& source, std::span<const float> points) {
      return joint_motions(source.rest().driven, points.subspan(source.rest().first_joint_coordinate()));
    };
    const auto then = of(rig, before), after = of(composed, now);
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 12; ++k) CHECK(std::fabs(then[j][k] - after[j][k]) < 1e-5);
  }
}

TEST_CASE("compositions do not depend on threads") {
  MemorySource rig = make_rig();
  CHECK(ComposedSource(rig, compose(rig, 1)).version() == ComposedSource(rig, compose(rig, 4)).version());
}

TEST_CASE("what was evaluated before a rig is composed is not asked again") {
  MemorySource source = make_rig();
  RigEvaluator rig(source);
  std::vector<JointComposition> compositions = compose_joints(rig, 1e-4, silent_progress());
  const std::uint64_t asked = rig.requested();
  rig.convert<ComposedSource>(compositions);
  ComposedSource composed(source, std::move(compositions));
  CHECK(rig.rest().driven == composed.rest().driven);
  CHECK(rig.version() == composed.version());
  std::vector<float> end(controls), points(rig.coordinate_count()), expected(points.size());
  end[7] = 1;
  rig.evaluate_cached(end, 1, points);
  composed.evaluate(end, 1, expected);
  CHECK(points == expected);
  CHECK(rig.requested() == asked);
}

TEST_CASE("joints that turn by sums are left as they are") {
  MemorySource rig(
      4, side,
      [](const float* c, std::span<float> points) {
        const std::size_t first = points.size() - 3;
        points[first] = 0.8f * c[0] + 0.3f * c[1], points[first + 1] = 0.5f * c[1] - 0.4f * c[2],
        points[first + 2] = 0.7f * c[3];
      },
      true);
  Mesh& rest = rig.edit_rest();
  rest.driven.joints = {{"sum", no_joint, joint_rotation, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}};
  rest.driven.skin = {1, std::vector<std::uint16_t>(side * side), std::vector<float>(side * side, 1)};
  add_joint_vertices(rest);
  rest.driven.scales.assign(3, 1);
  CHECK(compose(rig).empty());
}

}  // namespace test_compose_joints
