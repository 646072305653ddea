// The recipe that learns nothing: what it gives of a live rig, and what rights it needs.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "bake/measure/certificate.h"
#include "bake/pipeline/bake.h"
#include "bake/pipeline/compare.h"
#include "bake/rig/json_field.h"
#include "bake_test_support.h"
#include "toy_faces.h"

namespace test_untrained {

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;
using namespace fb::test;

namespace {

// Curves, a product of two controls and one of three.
void composed_formula(const float* controls, std::span<float> points) {
  curved_formula(controls, points);
  const auto c = shares(controls);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] +=
        0.3f * std::sin(2 * c[3]) * std::sin(0.7f * float(i)) + 0.2f * c[0] * c[2] * c[3] * std::cos(0.9f * float(i));
}

MemorySource composed_rig() {
  MemorySource rig = face_of(composed_formula, true);
  rig.add_clip("unseen", ClipKind::shot, Split::test, 200, 0.7f, 5);
  return rig;
}

MemorySource forbidden_rig() {
  MemorySource rig = composed_rig();
  rig.edit_character().about = R"({"rights":{"learning":"forbidden"}})";
  return rig;
}

Baked baked(MemorySource rig, const std::string& recipe, const WorkFolder& folder, const std::string& about = "") {
  BakeOptions options = options_in(folder, recipe);
  options.poses = 300;
  options.epochs = 2;
  options.about = about;
  return bake_face(rig, options, silent_progress());
}

}  // namespace

TEST_CASE("without learning, what single controls and a few together do is all there is, and exact") {
  const WorkFolder folder;
  const Baked face = baked(composed_rig(), "untrained", folder);
  REQUIRE(face.independent);
  CHECK(face.independent->total.max < 1e-4);
  CHECK(face.parameters == 0);
  CHECK(face.held_back.total.frames >= 300);  // every pose is one that nothing was fitted to
  const Archive archive = read_archive(face.archive);
  CHECK(archive.model.regions.empty());
  CHECK(object_in(archive.model.provenance).at("learned") == "no");
  CHECK(object_in(archive.text.certificate).at("learned") == "no");
  CHECK(certificate_summary(archive.text.certificate).starts_with("learned: no\n"));
}

TEST_CASE("without learning, the poses that measure a face change nothing of it") {
  const WorkFolder folder, other;
  const PackedModel a = read_archive(baked(composed_rig(), "untrained", folder).archive).model;
  MemorySource rig = composed_rig();
  rig.add_clip("more", ClipKind::dense, Split::train, 100, 0.9f, 9);
  const PackedModel b = read_archive(baked(std::move(rig), "untrained", other).archive).model;
  REQUIRE(a.features.size() == b.features.size());
  CHECK(a.columns == b.columns);
  CHECK(a.rest.points == b.rest.points);
}

TEST_CASE("recipes that learn say so") {
  const WorkFolder folder;
  const Archive archive = read_archive(baked(composed_rig(), "paper", folder).archive);
  CHECK(object_in(archive.model.provenance).at("learned") == "yes");
  CHECK(object_in(archive.text.certificate).at("learned") == "yes");
  CHECK(!contains(certificate_summary(archive.text.certificate), "learned"));
}

TEST_CASE("a recording has no controls to move: without learning, nothing can be made of it") {
  const WorkFolder folder;
  const std::string what = failure(Status::invalid_argument, [&] { baked(curved_face(), "untrained", folder); });
  CHECK_MESSAGE(contains(what, "is a recording, and recipe \"untrained\" fits nothing to poses"), what);
}

TEST_CASE("who may not learn from a character is told which recipe does not") {
  for (const char* recipe : {"hero", "compact", "paper", "kavan2024"}) {
    const WorkFolder folder;
    const std::string what = failure(Status::invalid_argument, [&] { baked(forbidden_rig(), recipe, folder); });
    CHECK_MESSAGE(contains(what, "\"untrained\""), what);
    CHECK_MESSAGE(contains(what, "learning from it is forbidden (learning: forbidden), and"), what);
  }
  for (const char* recipe : {"untrained", "linear"}) {
    const WorkFolder folder;
    CHECK(object_in(read_archive(baked(forbidden_rig(), recipe, folder).archive).model.provenance).at("learned") ==
          "no");
  }
  // linear fits blendshapes to a recording.
  MemorySource recording = curved_face();
  recording.edit_character().about = R"({"rights":{"learning":"forbidden"}})";
  const WorkFolder folder;
  CHECK(
      contains(failure(Status::invalid_argument, [&] { baked(std::move(recording), "linear", folder); }), "learning"));
}

TEST_CASE("what a source forbids, nobody who bakes it allows") {
  for (const char* about :
       {R"({"rights":{"learning":"allowed"}})", R"({"rights":{"learning":null}})", R"({"rights":null})"}) {
    const WorkFolder folder;
    const std::string what =
        failure(Status::invalid_argument, [&] { baked(forbidden_rig(), "untrained", folder, about); });
    CHECK_MESSAGE(contains(what, "the stricter holds"), what);
  }
  const WorkFolder folder;
  const std::string what = failure(Status::invalid_argument, [&] {
    baked(composed_rig(), "hero", folder, R"({"rights":{"learning":"forbidden"}})");
  });
  CHECK_MESSAGE(contains(what, "\"untrained\""), what);
}

TEST_CASE("a comparison learns only from whom it may") {
  const WorkFolder folder;
  MemorySource rig = forbidden_rig();
  BakeOptions options = options_in(folder);
  options.poses = 300;
  const std::string what = failure(Status::invalid_argument, [&] {
    compare(rig, {"linear", "paper"}, options, silent_progress());
  });
  CHECK_MESSAGE(contains(what, "\"paper\""), what);
  const CompareReport report = compare(rig, {"linear", "untrained"}, options, silent_progress());
  CHECK(report.methods.size() >= 2);
}

TEST_CASE("within a budget, the analysis has most of it, and no network chooses poses") {
  const WorkFolder folder;
  MemorySource rig = composed_rig();
  BakeOptions options = options_in(folder, "untrained");
  options.rig_budget = 1000;
  const Baked face = bake_face(rig, options, silent_progress());
  CHECK(face.asked <= 1000);
  for (const StageCalls& stage : face.asked_by_stage) CHECK(stage.stage != "poses where an ensemble disagrees");
  CHECK(face.independent->total.max < 1e-3);
}

}  // namespace test_untrained
