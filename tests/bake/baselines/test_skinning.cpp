#include <doctest/doctest.h>

#include <cmath>

#include "bake/baselines/skinning/bone_fitter.h"
#include "bake/baselines/skinning/bone_weights.h"
#include "bake/baselines/skinning/linear_transforms.h"
#include "bake/baselines/skinning/skeleton.h"
#include "base/status.h"
#include "memory_source.h"

namespace test_skinning {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 12;

// The weight of the second bone at a vertex: 0 on the left third, 1 on the right third, linear in between.
float bone_weight(std::size_t vertex) {
  return std::clamp((float(vertex % side) - 4) / 3, 0.0f, 1.0f);
}

// A grid whose right part rotates about x = 5.5 and translates; the left part stays.
void bend(const float* controls, std::span<float> points) {
  const float angle = 0.5f * controls[0], cosine = std::cos(angle), sine = std::sin(angle);
  for (std::size_t v = 0; v < points.size() / 3; ++v) {
    float* p = points.data() + 3 * v;
    const float x = p[0] - 5.5f, z = p[2], w = bone_weight(v);
    p[0] += w * (cosine * x + sine * z - x);
    p[1] += w * controls[1];
    p[2] += w * (cosine * z - sine * x - z);
  }
}

MemorySource bending_face() {
  MemorySource source(2, side, bend);
  source.add_clip("poses", ClipKind::dense, Split::train, 40, 1, 1);
  return source;
}

PoseSet all_of(Source& source) {
  return PoseSet(source, [](const Clip&) { return true; });
}

// The largest error along an axis of skinning with fitted transforms, over the diagonal.
double worst_error(const Skeleton& skeleton, const PoseSet& poses) {
  const Mesh& rest = poses.source().rest();
  const BoneFitter fitter(skeleton, rest);
  std::vector<float> moved(rest.points.size()), transforms(skeleton.parameter_count());
  double worst = 0;
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    poses.read_displacements(pose, 1, moved);
    fitter.fit(moved, transforms, false, 10);
    add_skinned(skeleton, rest, transforms, -1, moved);
    for (const float left : moved) worst = std::max(worst, std::abs(double(left)));
  }
  return worst / rest.diagonal();
}

}  // namespace

TEST_CASE("two planted bones are found, with their weights") {
  MemorySource source = bending_face();
  const PoseSet poses = all_of(source);
  const Skeleton skeleton = extract_skeleton(poses, {.bones = 2, .smoothing = 0}, {}, silent_progress());
  REQUIRE(skeleton.bone_count() == 2);
  const std::uint32_t moving = skeleton.bones[side - 1][0];
  for (std::size_t v = 0; v < side * side; ++v) {
    float weight = 0, sum = 0;
    for (std::size_t i = 0; i < bones_per_vertex; ++i) {
      CHECK(skeleton.weights[v][i] >= 0);
      sum += skeleton.weights[v][i];
      if (skeleton.bones[v][i] == moving) weight += skeleton.weights[v][i];
    }
    CHECK(sum == doctest::Approx(1));
    CHECK(std::abs(weight - bone_weight(v)) < 0.02f);
  }
  CHECK(worst_error(skeleton, poses) < 1e-3);
}

TEST_CASE("smoothing makes weights vary less along the mesh") {
  MemorySource source(2, side, [](const float* c, std::span<float> points) {
    bend(c, points);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] += 0.2f * std::sin(37 * c[0] + 91 * c[1] + 7.3f * float(i));
  });
  source.add_clip("poses", ClipKind::dense, Split::train, 12, 1, 1);
  const PoseSet poses = all_of(source);
  const auto roughness = [&](double smoothing) {
    return weight_roughness(extract_skeleton(poses, {.bones = 2, .smoothing = smoothing}, {}, silent_progress()),
                            source.rest());
  };
  const double rough = roughness(0), smooth = roughness(3e-2), smoother = roughness(1e-1);
  CHECK(smooth < 0.8 * rough);
  CHECK(smoother < 0.8 * smooth);
}

TEST_CASE("skinning shapes are the displacements by one unit of each transform parameter") {
  MemorySource source = bending_face();
  const Skeleton skeleton = extract_skeleton(all_of(source), {.bones = 3, .rounds = 2}, {}, silent_progress());
  const std::size_t rows = source.rest().points.size();
  const std::vector<float> shapes = skinning_shapes(skeleton, source.rest());
  REQUIRE(shapes.size() == skeleton.parameter_count() * rows);
  std::vector<float> transforms(skeleton.parameter_count()), sum(rows, 0.0f);
  for (std::size_t n = 0; n < transforms.size(); ++n) {
    transforms[n] = 0.1f * std::sin(float(n));
    for (std::size_t i = 0; i < rows; ++i) sum[i] += transforms[n] * shapes[n * rows + i];
    for (std::size_t i = 0; i < rows; ++i)
      if (i % 3 != n % 12 / 4) CHECK(shapes[n * rows + i] == 0);
  }
  add_skinned(skeleton, source.rest(), transforms, -1, sum);
  for (const float left : sum) CHECK(std::abs(left) < 1e-4f);
}

TEST_CASE("linear transforms of shapes are found, and the share of them that moves most is kept") {
  const MemorySource source = bending_face();
  const Mesh& rest = source.rest();
  Skeleton skeleton;
  skeleton.centres = {{1, 2, 0}, {9, 2, 0}};
  for (std::size_t v = 0; v < rest.vertex_count(); ++v) {
    skeleton.bones.push_back({0, 1, 0, 0});
    skeleton.weights.push_back({1 - bone_weight(v), bone_weight(v), 0, 0});
  }
  // The first shape is one bone's, the second both bones', of which the second moves less.
  const std::size_t parameters = skeleton.parameter_count(), rows = rest.points.size();
  std::vector<float> given(2 * parameters), shapes(2 * rows);
  for (std::size_t k = 0; k < 12; ++k) {
    given[k] = 0.1f * float(k % 5) - 0.2f;
    given[parameters + k] = 0.05f * float(k % 7) - 0.1f;
    given[parameters + 12 + k] = 1e-3f * float(k % 3);
  }
  for (std::size_t s = 0; s < 2; ++s)
    add_skinned(skeleton, rest, std::span(given).subspan(s * parameters, parameters), 1,
                std::span(shapes).subspan(s * rows, rows));
  const std::vector<float> all = fit_linear_transforms(skeleton, rest, shapes, 1, {});
  for (std::size_t i = 0; i < given.size(); ++i) CHECK(all[i] == doctest::Approx(given[i]).scale(1).epsilon(1e-3));
  const std::vector<float> half = fit_linear_transforms(skeleton, rest, shapes, 0.5, {});
  const auto is_0 = [](float value) { return value == 0; };
  CHECK(std::all_of(half.begin() + 12, half.begin() + std::ptrdiff_t(parameters), is_0));
  CHECK(std::all_of(half.begin() + std::ptrdiff_t(parameters) + 12, half.end(), is_0));
  for (std::size_t k = 0; k < 12; ++k) CHECK(half[k] == doctest::Approx(given[k]).scale(1).epsilon(1e-3));
}

TEST_CASE("solve_simplex finds the optimal weights") {
  // Two motions, (1, 0) and (0, 1): the nearest point on the segment between them, and its ends.
  const Eigen::MatrixXd quadratic = Eigen::MatrixXd::Identity(2, 2);
  CHECK(solve_simplex(quadratic, Eigen::Vector2d(0.7, 0.3))[0] == doctest::Approx(0.7).epsilon(1e-3));
  CHECK(solve_simplex(quadratic, Eigen::Vector2d(2, 0))[0] == doctest::Approx(1).epsilon(1e-3));
  CHECK(solve_simplex(quadratic, Eigen::Vector2d(0.2, 0.2))[0] == doctest::Approx(0.5).epsilon(1e-3));
  // A third motion far off gets weight 0.
  Eigen::MatrixXd three = Eigen::MatrixXd::Identity(3, 3);
  three(2, 2) = 100;
  const Eigen::VectorXd weights = solve_simplex(three, Eigen::Vector3d(0.6, 0.4, -1));
  CHECK(weights[2] == 0);
  CHECK(weights[0] == doctest::Approx(0.6).epsilon(1e-3));
}

TEST_CASE("a skeleton does not depend on the number of threads") {
  MemorySource source = bending_face();
  const Skeleton one = extract_skeleton(all_of(source), {.bones = 4}, {.threads = 1}, silent_progress());
  const Skeleton three = extract_skeleton(all_of(source), {.bones = 4}, {.threads = 3}, silent_progress());
  CHECK(one.bones == three.bones);
  CHECK(one.weights == three.weights);
}

TEST_CASE("skeletons of one pose, of a mesh without polygons, and of poses that do not move") {
  MemorySource source = bending_face();
  source.edit_rest().polygon_sizes.clear();
  source.edit_rest().polygon_corners.clear();
  const Skeleton loose = extract_skeleton(all_of(source).subsampled(1), {.bones = 6}, {}, silent_progress());
  CHECK(loose.bone_count() >= 1);
  CHECK(loose.bone_count() <= 6);
  MemorySource still(1, 4, [](const float*, std::span<float>) {});
  still.add_clip("poses", ClipKind::dense, Split::train, 3, 1, 1);
  CHECK(extract_skeleton(all_of(still), {}, {}, silent_progress()).bone_count() == 1);
  const PoseSet none(still, [](const Clip&) { return false; });
  CHECK_THROWS_AS(extract_skeleton(none, {}, {}, silent_progress()), Error);
}

}  // namespace test_skinning
