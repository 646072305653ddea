#include "bake/regions/local_basis.h"

#include <doctest/doctest.h>

#include <cmath>

#include "base/status.h"
#include "memory_source.h"

namespace test_local_basis {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 14, control_count = 6;

// The linear part: control k moves every coordinate along a wave.
float linear_shape(std::size_t k, std::size_t i) {
  return 0.3f * std::sin(0.11f * float((k + 1) * i));
}

// The residual: products of neighbouring controls, stronger on the left.
float corrective(const float* c, std::size_t i) {
  float sum = 0;
  const float fall = 1.0f / (1.0f + 0.2f * float(i / 3 % side));
  for (std::size_t k = 0; k + 1 < control_count; ++k)
    sum += c[k] * c[k + 1] * 0.2f * fall * std::cos(0.23f * float((k + 2) * i) + float(k));
  return sum;
}

MemorySource planted_rig(std::size_t poses) {
  MemorySource source(control_count, side, [](const float* c, std::span<float> points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t k = 0; k < control_count; ++k) points[i] += c[k] * linear_shape(k, i);
      points[i] += corrective(c, i);
    }
  });
  source.add_clip("rest", ClipKind::excitation, Split::train, 3, 0.0f, 1);
  source.add_clip("poses", ClipKind::dense, Split::train, poses, 0.8f, 2);
  return source;
}

SparseBlendshapes planted_base() {
  SparseBlendshapes base;
  for (std::uint32_t k = 0; k < control_count; ++k) {
    base.features.push_back({.kind = Feature::Kind::identity, .control = k});
    SparseShape shape{k, {}, {}};
    for (std::uint32_t v = 0; v < side * side; ++v) {
      shape.vertices.push_back(v);
      for (std::size_t axis = 0; axis < 3; ++axis) shape.offsets.push_back(linear_shape(k, 3 * v + axis));
    }
    base.shapes.push_back(shape);
  }
  return base;
}

// Left and right halves with weights that blend linearly; the last row of vertices is in neither.
std::vector<FaceRegion> halves() {
  std::vector<FaceRegion> regions(2);
  for (std::uint32_t v = 0; v < side * (side - 1); ++v) {
    const float right = std::clamp((float(v % side) - 5) / 3, 0.0f, 1.0f);
    for (std::size_t r = 0; r < 2; ++r) {
      const float weight = r ? right : 1 - right;
      if (weight <= 0) continue;
      regions[r].vertices.push_back(v);
      regions[r].weights.push_back(weight);
    }
  }
  regions[0].name = "left";
  regions[1].name = "right";
  return regions;
}

std::vector<float> read_all(const Residual& residual, const Parallel& parallel = {}) {
  std::vector<float> values(residual.size() * residual.rows());
  residual.read(0, residual.size(), values, parallel);
  return values;
}

// Largest distance, over the diagonal, between a region's weighted residual and its reconstruction.
double worst_error(const LocalBasis& basis, const FaceRegion& region, const Residual& residual,
                   const std::vector<float>& values) {
  double worst = 0;
  for (std::size_t pose = 0; pose < residual.size(); ++pose)
    for (std::size_t i = 0; i < region.vertices.size(); ++i) {
      double squared = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double e = double(region.weights[i]) * values[pose * residual.rows() + 3 * region.vertices[i] + axis];
        for (std::size_t k = 0; k < basis.count; ++k)
          e -= double(basis.coefficients[pose * basis.count + k]) * basis.components[k * basis.rows + 3 * i + axis];
        squared += e * e;
      }
      worst = std::max(worst, squared);
    }
  return std::sqrt(worst) / residual.poses().source().rest().diagonal();
}

}  // namespace

TEST_CASE("the residual is the displacement minus the blendshapes, and exactly 0 at rest") {
  MemorySource source = planted_rig(100);
  const PoseSet poses(source, [](const Clip&) { return true; });
  const SparseBlendshapes base = planted_base();
  const Residual residual(poses, base);
  const std::vector<float> values = read_all(residual), controls = poses.controls();
  double worst = 0;
  for (std::size_t pose = 0; pose < poses.size(); ++pose)
    for (std::size_t i = 0; i < residual.rows(); ++i)
      worst = std::max(worst, std::abs(double(values[pose * residual.rows() + i]) -
                                       corrective(controls.data() + pose * control_count, i)));
  CHECK(worst < 1e-5);
  for (std::size_t i = 0; i < 3 * residual.rows(); ++i) CHECK(values[i] == 0);
  CHECK(values == read_all(residual, {.threads = 3}));

  std::vector<float> few(20 * residual.rows());
  residual.read(37, 20, few, {.threads = 2});
  CHECK(std::equal(few.begin(), few.end(), values.begin() + std::ptrdiff_t(37 * residual.rows())));
  CHECK_THROWS_AS(residual.read(90, 20, few, {}), Error);
}

TEST_CASE("a local basis reconstructs its region as well as its truncation error says") {
  MemorySource source = planted_rig(900);
  const PoseSet poses(source, [](const Clip&) { return true; });
  const SparseBlendshapes base = planted_base();
  const Residual residual(poses, base);
  const std::vector<float> values = read_all(residual);
  const std::vector<FaceRegion> regions = halves();
  const std::vector<LocalBasis> bases = local_bases(residual, regions, {.max_error = 1e-4}, {}, silent_progress());
  REQUIRE(bases.size() == 2);
  for (std::size_t r = 0; r < 2; ++r) {
    const LocalBasis& basis = bases[r];
    CHECK(basis.rows == 3 * regions[r].vertices.size());
    CHECK(basis.count == control_count - 1);  // as many as there are products of controls
    CHECK(basis.max_error <= 1e-4);
    CHECK(basis.rms_error <= basis.max_error);
    CHECK(worst_error(basis, regions[r], residual, values) < 1e-6);  // all poses were fitted, and nothing is lost
    std::vector<double> variance(basis.count, 0);
    for (std::size_t pose = 0; pose < poses.size(); ++pose)
      for (std::size_t k = 0; k < basis.count; ++k)
        variance[k] += std::pow(double(basis.coefficients[pose * basis.count + k]), 2);
    for (std::size_t k = 1; k < basis.count; ++k) CHECK(variance[k] <= variance[k - 1]);
    for (std::size_t i = 0; i < 3 * basis.count; ++i) CHECK(basis.coefficients[i] == 0);  // at rest
    for (std::size_t a = 0; a < basis.count; ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        double dot = 0;
        for (std::size_t i = 0; i < basis.rows; ++i)
          dot += double(basis.components[a * basis.rows + i]) * basis.components[b * basis.rows + i];
        CHECK(dot == doctest::Approx(a == b).epsilon(1e-4));
      }
  }
}

TEST_CASE("as many components are kept as max_error needs") {
  // 40 shapes of falling size.
  std::vector<float> shapes;
  for (std::size_t i = 0; i < 3 * side * side; ++i)
    for (std::size_t k = 0; k < 40; ++k)
      shapes.push_back(std::pow(0.8f, float(k)) * std::sin(0.37f * float((k + 1) * i) + float(k)));
  MemorySource source(40, side, [&](const float* c, std::span<float> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t k = 0; k < 40; ++k) points[i] += c[k] * shapes[40 * i + k];
  });
  source.add_clip("poses", ClipKind::dense, Split::train, 700, 1.0f, 2);
  const PoseSet poses(source, [](const Clip&) { return true; });
  const SparseBlendshapes nothing;
  const Residual residual(poses, nothing);
  const std::vector<float> values = read_all(residual);
  const std::vector<FaceRegion> regions = halves();
  std::size_t last = 0;
  for (const double tolerance : {0.1, 0.01, 1e-3, 1e-5}) {
    const auto bases =
        local_bases(residual, regions, {.max_error = tolerance, .max_fit_poses = 1000}, {}, silent_progress());
    for (std::size_t r = 0; r < 2; ++r) {
      CHECK(bases[r].max_error <= tolerance);
      CHECK(worst_error(bases[r], regions[r], residual, values) == doctest::Approx(bases[r].max_error).epsilon(0.02));
    }
    CHECK(bases[0].count >= last);
    last = bases[0].count;
  }
  CHECK(last == 40);
  // With max_components too small, all are used and the truncation error is reported.
  const auto capped = local_bases(residual, regions, {.max_error = 1e-5, .max_components = 12}, {}, silent_progress());
  CHECK(capped[0].count == 12);
  CHECK(capped[0].max_error > 1e-5);
  CHECK(worst_error(capped[0], regions[0], residual, values) == doctest::Approx(capped[0].max_error).epsilon(0.01));
  // The optimal 12 components lose this much; subspace iteration comes close.
  const auto full = local_bases(residual, regions, {.max_error = 0}, {}, silent_progress());
  double tail = 0, lost = 0;
  for (std::size_t pose = 0; pose < poses.size(); ++pose)
    for (std::size_t k = 12; k < full[0].count; ++k)
      tail += std::pow(double(full[0].coefficients[pose * full[0].count + k]), 2);
  lost = std::pow(capped[0].rms_error * source.rest().diagonal(), 2) * double(poses.size() * capped[0].rows / 3);
  CHECK(lost < 1.02 * tail);
  CHECK(lost > 0.98 * tail);
}

TEST_CASE("bases fitted to some poses project all, with the same bits for any number of threads") {
  MemorySource source = planted_rig(2500);
  const PoseSet poses(source, [](const Clip&) { return true; });
  const SparseBlendshapes base = planted_base();
  const Residual residual(poses, base);
  const std::vector<FaceRegion> regions = halves();
  const LocalBasisOptions options{.max_error = 1e-3, .max_components = 30, .max_fit_poses = 400};
  const std::vector<LocalBasis> one = local_bases(residual, regions, options, {.threads = 1}, silent_progress());
  const std::vector<LocalBasis> three = local_bases(residual, regions, options, {.threads = 3}, silent_progress());
  const std::vector<float> values = read_all(residual);
  for (std::size_t r = 0; r < 2; ++r) {
    CHECK(one[r].coefficients.size() == poses.size() * one[r].count);
    CHECK(worst_error(one[r], regions[r], residual, values) < 2e-3);
    CHECK(one[r].components == three[r].components);
    CHECK(one[r].coefficients == three[r].coefficients);
    CHECK(one[r].max_error == three[r].max_error);
    CHECK(one[r].rms_error == three[r].rms_error);
  }
}

TEST_CASE("few poses, regions that do not move, and invalid regions") {
  MemorySource source = planted_rig(2);
  const PoseSet poses(source, [](const Clip&) { return true; });
  const SparseBlendshapes base = planted_base();
  const Residual residual(poses, base);
  std::vector<FaceRegion> regions = halves();
  const auto bases = local_bases(residual, regions, {}, {}, silent_progress());
  CHECK(bases[0].count == 2);
  CHECK(local_bases(residual, {}, {}, {}, silent_progress()).empty());

  const PoseSet rest(source, [](const Clip& clip) { return clip.name == "rest"; });
  const Residual still(rest, base);
  const auto idle = local_bases(still, regions, {}, {}, silent_progress());
  CHECK(idle[0].count == 1);
  CHECK(idle[0].coefficients == std::vector<float>(3, 0.0f));

  regions[0].vertices.back() = side * side;
  CHECK_THROWS_AS(local_bases(residual, regions, {}, {}, silent_progress()), Error);
  regions = halves();
  regions[1].weights.pop_back();
  CHECK_THROWS_AS(local_bases(residual, regions, {}, {}, silent_progress()), Error);
  CHECK_THROWS_AS(local_bases(residual, halves(), {.max_components = 0}, {}, silent_progress()), Error);
}

}  // namespace test_local_basis
