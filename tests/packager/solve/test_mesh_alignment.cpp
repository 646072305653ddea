// Other meshes brought onto the face, where they came from being known.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/status.h"
#include "head_meshes.h"
#include "solve/first_guesses.h"
#include "solve/mesh_alignment.h"

using namespace fb;
using namespace fb::tool;
using namespace fb::test;

namespace test_mesh_alignment {

constexpr std::size_t samples = 1500;

const SampledSurface& face() {
  static const SampledSurface surface(sample_head().view(), samples);
  return surface;
}

Similarity turned(Vector3 axis, double degrees, double scale, std::array<double, 3> translation) {
  const double angle = degrees * M_PI / 180, c = std::cos(angle), s = std::sin(angle), d = 1 - c;
  const Vector3 n = normalized(axis);
  const double x = n.x, y = n.y, z = n.z;
  return {{c + d * x * x, d * x * y - s * z, d * x * z + s * y, d * x * y + s * z, c + d * y * y, d * y * z - s * x,
           d * x * z - s * y, d * y * z + s * x, c + d * z * z},
          scale,
          translation};
}

// Y up to Z up, centimetres to millimetres, somewhere else, and 12 degrees askew.
Similarity far_away() {
  return after(turned({1, 2, 3}, 12, 10, {300, -800, 1500}), turned({1, 0, 0}, 90, 1, {}));
}

struct Result {
  double millimetres = 0;  // of the vertex that ends farthest from where it was
  Alignment alignment;
};

Result align(const HeadMesh& other, const Similarity& moved_by, std::optional<double> scale = {}) {
  const SampledSurface surface(moved(other, moved_by).view(), samples);
  Result result;
  result.alignment = align_surfaces(surface, face(), {.scale = scale});
  result.millimetres = 10 * largest_error(sample_head(), moved_by, result.alignment.to_face);
  MESSAGE("off by ", result.millimetres, " mm, rms ", 10 * result.alignment.rms, " mm, kept ", result.alignment.kept,
          ", rival ", result.alignment.rival);
  return result;
}

TEST_CASE("pairs of points give back the similarity they were made by") {
  const Similarity truth = far_away();
  Random random(4);
  std::vector<PointPair> pairs;
  for (int i = 0; i < 20; ++i) {
    const Vector3 p = {random.normal(), random.normal(), random.normal()};
    pairs.push_back({p, truth(p), 0.5 + random.uniform()});
  }
  const auto found = align_pairs(pairs, {});
  REQUIRE(found);
  CHECK(found->scale == doctest::Approx(10).epsilon(1e-5));
  CHECK(degrees_apart(*found, truth) < 0.01);
  CHECK(length((*found)({1, 2, 3}) - truth({1, 2, 3})) < 1e-2f);
  const auto fixed = align_pairs(pairs, 5.0);
  REQUIRE(fixed);
  CHECK(fixed->scale == 5);
  CHECK(degrees_apart(*fixed, truth) < 0.01);
  const Vector3 back = truth.inverse()(truth({4, 5, 6}));
  CHECK(length(back - Vector3{4, 5, 6}) < 1e-3f);

  std::vector<PointPair> line;
  for (int i = 0; i < 5; ++i) line.push_back({{float(i), 0, 0}, {0, float(i), 0}});
  CHECK_FALSE(align_pairs(line, {}));
  CHECK_FALSE(align_pairs(std::span(pairs).first(2), {}));
}

TEST_CASE("there are 24 orientations with axes along axes, none of them a mirror image") {
  const std::vector<Similarity> rotations = axis_rotations();
  REQUIRE(rotations.size() == 24);
  for (std::size_t i = 0; i < 24; ++i)
    for (std::size_t j = 0; j < i; ++j) CHECK(degrees_apart(rotations[i], rotations[j]) > 89);
}

TEST_CASE("a mesh of another topology is found wherever it is, whatever its unit and axes") {
  const HeadMesh fine = dual_head(2), coarse = dual_head(1);
  CHECK(fine.points.size() > 3 * coarse.points.size());
  for (const HeadMesh* other : {&fine, &coarse}) {
    const Result result = align(*other, far_away());
    CHECK(result.millimetres < 0.5);
    CHECK(result.alignment.rms < 0.02);
    CHECK(result.alignment.kept > 0.6);
    CHECK(result.alignment.rival > 10);
  }
  const Result fixed = align(coarse, far_away(), 0.1);
  CHECK(fixed.alignment.to_face.scale == 0.1);
  CHECK(fixed.millimetres < 0.3);
}

TEST_CASE("neither noise nor a quarter that is missing leads astray") {
  const HeadMesh fine = dual_head(2);
  const HeadMesh cut = cut_beyond(fine, 2.6f);
  const double left = double(cut.corners.size()) / double(fine.corners.size());
  CHECK(left > 0.65);
  CHECK(left < 0.78);
  CHECK(align(cut, far_away()).millimetres < 0.6);
  CHECK(align(with_noise(cut, 0.05f), far_away()).millimetres < 1);
}

TEST_CASE("a mesh that is turned by any angle is found") {
  const HeadMesh coarse = dual_head(1);
  for (const double degrees : {45.0, 140.0})
    CHECK(align(coarse, turned({1, 1, -0.5f}, degrees, 2.5, {5, 6, 7})).millimetres < 0.6);
}

TEST_CASE("an alignment begins where it is told to, and stays in that orientation") {
  const SampledSurface other(moved(dual_head(1), far_away()).view(), samples);
  const Similarity rough = after(turned({0, 1, 0}, 9, 1.03, {0.5, -0.4, 0.3}), far_away().inverse());
  const Alignment near = align_surfaces(other, face(), {.scale_range = 1.2, .start = rough});
  CHECK(10 * largest_error(sample_head(), far_away(), near.to_face) < 0.6);
  CHECK(near.rival == INFINITY);
  const Similarity backwards = after(turned({0, 1, 0}, 180, 1, {}), far_away().inverse());
  const Alignment wrong = align_surfaces(other, face(), {.start = backwards});
  CHECK(degrees_apart(wrong.to_face, backwards) < 30);
  CHECK(wrong.to_face.scale == backwards.scale);
  CHECK(wrong.rms > 3 * near.rms);
}

TEST_CASE("planes that points lie on are reached in a few steps") {
  const Similarity truth = turned({1, 2, 3}, 5, 1.1, {0.1, 0.2, -0.3});
  Random random(6);
  std::vector<Vector3> points;
  std::vector<PlanePair> pairs;
  for (int i = 0; i < 50; ++i) {
    const Vector3 p = {random.normal(), random.normal(), random.normal()};
    points.push_back(p);
    pairs.push_back({p, truth(p), normalized({random.normal(), random.normal(), random.normal()})});
  }
  Similarity found;
  for (int step = 0; step < 6; ++step) {
    for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].from = found(points[i]);
    found = after(plane_step(pairs, false), found);
  }
  CHECK(found.scale == doctest::Approx(1.1).epsilon(1e-4));
  CHECK(degrees_apart(found, truth) < 0.01);
  CHECK(plane_step(pairs, true).scale == 1);
}

TEST_CASE("alignments have the same bits again, and on any number of threads") {
  const SampledSurface other(moved(dual_head(1), far_away()).view(), samples);
  const Alignment once = align_surfaces(other, face(), {.parallel = {.threads = 1}});
  const Alignment again = align_surfaces(other, face(), {.parallel = {.threads = 3}});
  CHECK(once.to_face.rotation == again.to_face.rotation);
  CHECK(once.to_face.translation == again.to_face.translation);
  CHECK(once.to_face.scale == again.to_face.scale);
  CHECK(once.rms == again.rms);
}

}  // namespace test_mesh_alignment
