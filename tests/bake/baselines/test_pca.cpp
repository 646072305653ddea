#include "bake/baselines/pca.h"

#include <doctest/doctest.h>

#include <cmath>

#include "base/status.h"
#include "memory_source.h"
#include "watched_progress.h"

namespace test_pca {

using namespace fb;
using namespace fb::bake;

namespace {

// Three fixed shapes of falling size, driven by the first three controls.
float shape(std::size_t k, std::size_t i) {
  return std::sin(0.37f * float((k + 1) * i) + float(k));
}
constexpr float sizes[] = {1.0f, 0.3f, 0.02f};

MemorySource three_shapes() {
  MemorySource source(4, 12, [](const float* c, std::span<float> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) points[i] += sizes[k] * c[k] * shape(k, i);
  });
  source.add_clip("poses", ClipKind::dense, Split::train, 300, 1.0f, 7);
  return source;
}

// Counts the steps of subspace iteration.
struct Passes final : test::QuietProgress {
  void begin(Phase, std::string_view stage, std::uint64_t) override { count += stage == "finding blendshapes"; }
  int count = 0;
};

double reconstruction_error(const PrincipalComponents& pca, const PoseSet& poses) {
  std::vector<float> block(pca.rows);
  double worst = 0;
  for (std::size_t p = 0; p < poses.size(); p += 97) {
    poses.read_displacements(p, 1, block);
    for (std::size_t i = 0; i < pca.rows; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < pca.count; ++k)
        sum += double(pca.components[k * pca.rows + i]) * pca.coefficients[p * pca.count + k];
      worst = std::max(worst, std::abs(sum - block[i]));
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("the fewest principal components that hold the given fraction are kept") {
  MemorySource source = three_shapes();
  const PoseSet poses(source, [](const Clip&) { return true; });
  const PrincipalComponents most = principal_components(Displacements(poses), 0.999, {}, silent_progress());
  CHECK(most.count == 2);
  CHECK(most.captured >= 0.999 * most.total);
  CHECK(reconstruction_error(most, poses) < 0.05);
  const PrincipalComponents all = principal_components(Displacements(poses), 0.99999, {}, silent_progress());
  CHECK(all.count == 3);
  CHECK(reconstruction_error(all, poses) < 2e-5);
  for (std::size_t a = 0; a < all.count; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      double dot = 0;
      for (std::size_t i = 0; i < all.rows; ++i)
        dot += double(all.components[a * all.rows + i]) * all.components[b * all.rows + i];
      CHECK(dot == doctest::Approx(a == b).epsilon(1e-5));
    }
}

TEST_CASE("a spectrum longer than the sample is found") {
  // Every row moves on its own in its own poses, so no small sample spans the set.
  MemorySource source(40, 6, [](const float* c, std::span<float> points) {
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += c[i % 40] * (1.0f + float(i) / 100.0f);
  });
  source.add_clip("poses", ClipKind::dense, Split::train, 1100, 0.05f, 3);
  const PoseSet poses(source, [](const Clip&) { return true; });
  const PrincipalComponents pca = principal_components(Displacements(poses), 0.99999, {}, silent_progress());
  CHECK(pca.captured >= 0.99999 * pca.total);
  CHECK(pca.count == 40);
  CHECK(reconstruction_error(pca, poses) < 1e-4);
}

TEST_CASE("shapes missing from the sample are found by a larger subspace") {
  MemorySource source(40, 6, [](const float* c, std::span<float> points) {
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += c[i % 40] * (1.0f + float(i) / 100.0f);
  });
  source.add_clip("poses", ClipKind::dense, Split::train, 2048, 0, 1);
  std::vector<float>& controls = source.edit_clip(0).controls;
  for (std::size_t pose = 0; pose < 2048; ++pose)  // the sample is every second pose
    controls[pose * 40 + (pose % 2 ? pose / 2 % 40 : 0)] = 1;
  const PoseSet poses(source, [](const Clip&) { return true; });
  Passes passes;
  const PrincipalComponents pca = principal_components(Displacements(poses), 0.99999, {}, passes);
  CHECK(passes.count > 1);
  CHECK(pca.captured >= 0.99999 * pca.total);
  CHECK(pca.count == 40);
}

TEST_CASE("all poses of a long recording are used, and one iteration is enough where the sample has all shapes") {
  MemorySource source = three_shapes();
  source.add_clip("more", ClipKind::dense, Split::train, 5000, 1.0f, 8);
  source.add_clip("rest", ClipKind::dense, Split::train, 300, 0, 9);
  const PoseSet poses(source, [](const Clip&) { return true; });
  Passes passes;
  const PrincipalComponents pca = principal_components(Displacements(poses), 0.999, {}, passes);
  CHECK(passes.count == 1);
  CHECK(pca.count == 2);
  CHECK(pca.captured >= 0.999 * pca.total);
  CHECK(reconstruction_error(pca, poses) < 0.05);
}

TEST_CASE("components do not depend on the number of threads") {
  MemorySource source = three_shapes();
  const PoseSet poses(source, [](const Clip&) { return true; });
  const PrincipalComponents one = principal_components(Displacements(poses), 0.999, {.threads = 1}, silent_progress());
  const PrincipalComponents three =
      principal_components(Displacements(poses), 0.999, {.threads = 3}, silent_progress());
  CHECK(one.components == three.components);
  CHECK(one.coefficients == three.coefficients);
}

TEST_CASE("poses that move nothing are refused") {
  MemorySource source(2, 4, [](const float*, std::span<float>) {});
  source.add_clip("still", ClipKind::dense, Split::train, 10, 1.0f, 1);
  const PoseSet poses(source, [](const Clip&) { return true; });
  CHECK_THROWS_AS(principal_components(Displacements(poses), 0.999, {}, silent_progress()), Error);
  const PoseSet none(source, [](const Clip&) { return false; });
  CHECK_THROWS_AS(principal_components(Displacements(none), 0.999, {}, silent_progress()), Error);
}

}  // namespace test_pca
