#include "bake/face/region_poses.h"

#include <doctest/doctest.h>

#include <cmath>

#include "toy_faces.h"

namespace test_region_poses {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t controls = 6, side = 6, vertices = side * side, components = 2;

// What the first three controls do together moves the left half, what the others do the right one.
void two_halves(const float* c, std::span<float> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float* const of_half = i / 3 % side < side / 2 ? c : c + 3;
    points[i] += (0.5f * of_half[0] * of_half[1] + 0.1f * of_half[2]) * std::cos(0.7f * float(i));
  }
}

// The same with a motion that saturates, which is left to networks.
void saturating_halves(const float* c, std::span<float> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float* const of_half = i / 3 % side < side / 2 ? c : c + 3;
    points[i] +=
        0.5f * std::tanh(1.5f * (of_half[0] + 0.7f * of_half[1] - 0.6f * of_half[2])) * std::cos(0.3f * float(i));
  }
}

struct Halves {
  MemorySource rig{controls, side, two_halves, true};
  std::vector<FaceRegion> regions{2};
  std::vector<LocalBasis> bases{2};

  // The bases are of single coordinates, so that coefficients are residuals times blend weights.
  Halves() {
    for (std::uint32_t r = 0; r < 2; ++r) {
      regions[r].controls = {3 * r, 3 * r + 1, 3 * r + 2};
      regions[r].motion = {0.09f, 0.09f, 0.01f};
      for (std::uint32_t v = 0; v < vertices; ++v)
        if ((v % side < side / 2) == (r == 0)) regions[r].vertices.push_back(v);
      regions[r].weights.assign(regions[r].vertices.size(), 0.5f);
      bases[r].rows = 3 * regions[r].vertices.size();
      bases[r].count = components;
      bases[r].components.assign(components * bases[r].rows, 0);
      bases[r].components[0] = bases[r].components[bases[r].rows + 4] = 1;
    }
  }

  std::vector<RegionPoses> poses(const SparseBlendshapes& base, int threads = 0, std::uint64_t seed = 1) {
    RigEvaluator evaluator(rig, {threads});
    EvaluationStage stage(silent_progress(), Phase::training, "evaluating poses of single regions", 500);
    std::vector<RegionPoses> all;
    for (std::size_t r = 0; r < 2; ++r)
      all.push_back(region_poses(evaluator, base, regions[r], bases[r], r, r == 0 ? 300 : 200, seed, stage));
    return all;
  }
};

}  // namespace

TEST_CASE("sixteen times as many poses are of single regions, as long as all are at most 150,000") {
  CHECK(region_pose_count(1000) == 16000);
  CHECK(region_pose_count(20000) == 130000);
  CHECK(region_pose_count(150000) == 0);
  CHECK(region_pose_count(210000) == 0);
  const double errors[] = {4, 1, 0};
  CHECK(region_pose_counts(600, errors) == std::vector<std::size_t>{400, 200, 0});
  const double nothing[] = {0, 0};
  CHECK(region_pose_counts(600, nothing) == std::vector<std::size_t>{0, 0});
}

TEST_CASE("poses of a region move its controls alone, those more often that move it further") {
  Halves face;
  const std::vector<RegionPoses> found = face.poses({});
  REQUIRE(found.size() == 2);
  for (std::size_t r = 0; r < 2; ++r) {
    const std::size_t poses = r == 0 ? 300 : 200;
    REQUIRE(found[r].controls.size() == poses * controls);
    REQUIRE(found[r].coefficients.size() == poses * components);
    std::size_t active[controls] = {};
    for (std::size_t i = 0; i < found[r].controls.size(); ++i) {
      CHECK(std::abs(found[r].controls[i]) <= 1);
      active[i % controls] += found[r].controls[i] != 0;
    }
    for (std::size_t c = 0; c < controls; ++c)
      if (c / 3 != r) CHECK(active[c] == 0);
    CHECK(active[3 * r] > poses * 2 / 5);
    CHECK(active[3 * r + 1] > poses * 2 / 5);
    CHECK(active[3 * r + 2] > poses / 10);
    CHECK(active[3 * r + 2] < active[3 * r] / 2);
  }
}

TEST_CASE("coefficients are those of what blendshapes leave of the rig, whatever the number of threads") {
  Halves face;
  SparseBlendshapes base;  // what the third control does, of the first vertex alone
  base.features = {{Feature::Kind::identity, 2, 1, 0}};
  base.shapes = {{0, {0}, {0.1f, 0.1f * std::cos(0.7f), 0.1f * std::cos(1.4f)}}};
  const std::vector<RegionPoses> found = face.poses(base, 1);
  for (std::size_t r = 0; r < 2; ++r)
    for (std::size_t p = 0; p < found[r].coefficients.size() / components; ++p) {
      const float* const c = &found[r].controls[p * controls + 3 * r];
      const float single = 0.1f * c[2], pair = 0.5f * c[0] * c[1];
      // The first coordinate of the region's first vertex, and the second of its second one.
      const double first = 9.0 * double(r), second = first + 4;
      const double left = double(pair) + (r == 0 ? 0 : double(single));
      CHECK(found[r].coefficients[p * components] == doctest::Approx(0.5 * left * std::cos(0.7 * first)).epsilon(1e-4));
      CHECK(found[r].coefficients[p * components + 1] ==
            doctest::Approx(0.5 * double(pair + single) * std::cos(0.7 * second)).epsilon(1e-4));
    }
  const std::vector<RegionPoses> again = face.poses(base, 3), other = face.poses(base, 3, 2);
  for (std::size_t r = 0; r < 2; ++r) {
    CHECK(again[r].controls == found[r].controls);
    CHECK(again[r].coefficients == found[r].coefficients);
    CHECK(other[r].controls != found[r].controls);
  }
}

TEST_CASE("networks are trained on poses of their region where a rig may be asked without limit") {
  const auto bake = [](std::uint64_t budget) {
    const WorkFolder folder;
    MemorySource rig(controls, side, saturating_halves, true);
    rig.add_clip("unseen", ClipKind::shot, Split::test, 20, 0.7f, 5);
    BakeOptions options = options_in(folder, "compact");
    options.poses = budget ? budget : 300;
    options.rig_budget = budget;
    options.epochs = 1;
    return bake_face(rig, options, silent_progress());
  };
  const Baked free = bake(0), limited = bake(1200);
  for (const Baked* baked : {&free, &limited}) {
    REQUIRE(!baked->stats.regions.empty());
    std::size_t own = 0;
    for (const RegionStats& region : baked->stats.regions) own += region.poses - baked->poses;
    if (baked == &limited) CHECK(own == 0);
    if (baked == &free) CHECK(own + baked->stats.regions.size() > region_pose_count(baked->poses));
  }
}

}  // namespace test_region_poses
