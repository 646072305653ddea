// Which correctives are left to networks, and what of them stays.
#include <algorithm>

#include "bake/analysis/rig_analysis.h"
#include "bake_test_support.h"
#include "test_models.h"

namespace test_prune_correctives {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::uint32_t on_surface = 0, in_joint = 4;

// Five vertices, of which the last carries the numbers of a joint. Two controls, and a corrective of both that moves a
// vertex and a number by `offset`.
struct Analysed {
  Mesh rest;
  RigSchema schema;
  RigAnalysis analysis;

  explicit Analysed(float offset) {
    rest.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0};
    rest.carrier_vertices = 1;
    rest.driven.joints = {{"jaw", no_joint, joint_rotation, {}}};
    rest.driven.scales = {1, 1, 1};
    for (const char* name : {"open", "shift"}) schema.controls.push_back({name, -1, 1, 0, ""});
    std::vector<Feature>& features = analysis.base.features;
    features = {identity_of(0), identity_of(1), {Feature::Kind::product, 0, 1, 0, 0, 0, 1}};
    analysis.base.shapes = {{0, {on_surface}, {1, 0, 0}},
                            {1, {on_surface}, {0, 1, 0}},
                            {2, {on_surface, in_joint}, {offset, 0, 0, 0, offset, 0}}};
    analysis.correctives = {{{0, 1}, 1, {2}}};
    analysis.motion.assign(2 * rest.vertex_count(), 0);
    analysis.residual_motion = analysis.motion;
  }

  static Feature identity_of(std::uint32_t control) { return {Feature::Kind::identity, control, 1, 0, 0, 0, 0}; }

  std::size_t prune(double bytes) {
    return prune_correctives(analysis, schema, std::vector<float>{1, 1, 0.5f, -1}, rest, bytes);
  }
  bool leaves(std::uint32_t vertex) const {
    const std::size_t vertices = rest.vertex_count();
    return analysis.residual_motion[vertex] > 0 && analysis.residual_motion[vertices + vertex] > 0;
  }
};

}  // namespace

TEST_CASE("a corrective that has its bytes stays whole") {
  Analysed face(0.1f);
  CHECK(face.prune(3) == 0);
  CHECK(face.analysis.base.shapes.size() == 3);
  CHECK(face.analysis.base.shapes[2].vertices == std::vector<std::uint32_t>{on_surface, in_joint});
  CHECK_FALSE(face.leaves(on_surface));
}

TEST_CASE("one that has not leaves the surface to networks, and keeps its numbers of joints") {
  Analysed face(0.1f);
  CHECK(face.prune(2) == 1);
  REQUIRE(face.analysis.base.shapes.size() == 3);
  CHECK(face.analysis.base.shapes[2].vertices == std::vector<std::uint32_t>{in_joint});
  CHECK(face.analysis.base.shapes[2].offsets == std::vector<float>{0, 0.1f, 0});
  CHECK(face.leaves(on_surface));
  CHECK_FALSE(face.leaves(in_joint));
}

TEST_CASE("without numbers of joints the whole shape goes") {
  Analysed face(0.1f);
  face.analysis.base.shapes[2] = {2, {on_surface}, {0.1f, 0, 0}};
  CHECK(face.prune(2) == 1);
  CHECK(face.analysis.base.shapes.size() == 2);
  CHECK(face.analysis.base.features.size() == 3);
}

}  // namespace test_prune_correctives
