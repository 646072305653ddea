#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "dense/bumps.h"
#include "dense/dense_mesh.h"

using rigs::dense::DenseMesh;
using rigs::dense::Quads;

namespace {

// A strip of two quads.
const Quads strip = {{0, 1, 4, 3}, {1, 2, 5, 4}};
const std::vector<float> flat = {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0};

}  // namespace

TEST_CASE("quads are cut without gaps, and one division changes nothing") {
  const DenseMesh same(6, strip, 1);
  CHECK(same.quads() == strip);
  std::vector<float> points(3 * same.vertices());
  same.pose(flat.data(), points.data());
  CHECK(points == flat);

  const DenseMesh fine(6, strip, 3);
  CHECK(fine.vertices() == 7 * 4);
  CHECK(fine.quads().size() == 18);
  points.resize(3 * fine.vertices());
  fine.pose(flat.data(), points.data());
  double area = 0;
  for (const auto& q : fine.quads()) {
    const float *a = &points[3 * q[0]], *b = &points[3 * q[1]], *c = &points[3 * q[2]], *d = &points[3 * q[3]];
    area += 0.5 * ((c[0] - a[0]) * (d[1] - b[1]) - (d[0] - b[0]) * (c[1] - a[1]));
  }
  CHECK(area == doctest::Approx(2));
}

TEST_CASE("inner edges are rounded") {
  std::vector<float> bent = flat;
  for (const std::size_t v : {1, 4}) bent[3 * v + 2] = 1;  // a roof
  const DenseMesh fine(6, strip, 4);
  std::vector<float> points(3 * fine.vertices());
  fine.pose(bent.data(), points.data());
  float inner = 0;
  for (std::uint32_t v = 0; v < fine.vertices(); ++v)
    if (points[3 * v + 1] > 0.2f && points[3 * v + 1] < 0.8f) inner = std::max(inner, points[3 * v + 2]);
  CHECK(inner < 0.9f);
  CHECK(inner > 0.8f);
}

TEST_CASE("each further control moves a place of its own, less where another control acts") {
  const sample_face::Rig rig;
  const rigs::dense::Bumps bumps(rig, 40);
  REQUIRE(bumps.count() == 40);
  std::vector<float> controls(40), sample(rig.controls().list().size());
  const auto moved = [&](std::size_t bump, float at) {
    controls.assign(40, 0.0f);
    controls[bump] = 1;
    sample[bump] = at;
    std::vector<sample_face::Vec3> points = rig.rest();
    bumps.add(controls.data(), sample, points);
    float most = 0;
    std::size_t count = 0;
    for (std::size_t v = 0; v < points.size(); ++v) {
      const sample_face::Vec3 offset = points[v] - rig.rest()[v];
      most = std::max(most, std::sqrt(dot(offset, offset)));
      count += dot(offset, offset) > 0;
    }
    CHECK(count < points.size() / 10);
    return most;
  };
  CHECK(moved(7, 0) == doctest::Approx(0.3));
  CHECK(moved(7, 1) == doctest::Approx(0.15));
  CHECK(bumps.value_in_clip(6, 3) == 0);
  CHECK(bumps.value_in_clip(5, 3) != bumps.value_in_clip(5, 9));
}
