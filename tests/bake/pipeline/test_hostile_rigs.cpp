// Rigs of extraordinary size, rigs that do not repeat themselves, and faces that are worse than no face.
#include <cmath>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/repeatability.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/compare.h"
#include "bake/rig/scaled_source.h"
#include "bake_test_support.h"
#include "toy_faces.h"

namespace test_hostile_rigs {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

BakeOptions quick(const WorkFolder& folder, const std::string& recipe) {
  BakeOptions options = options_in(folder, recipe);
  options.epochs = 3;
  options.poses = 300;
  return options;
}

Baked bake_quickly(Source& source, const std::string& recipe, std::uint64_t rig_budget = 0) {
  const WorkFolder folder;
  BakeOptions options = quick(folder, recipe);
  options.rig_budget = rig_budget;
  return bake_face(source, options, silent_progress());
}

// Random poses of a live rig, and the errors of a face on them.
EvalReport errors_on(const std::vector<std::byte>& archive, Source& rig) {
  const WorkFolder folder;
  RigEvaluator evaluator(rig);
  fb::bake::sample(evaluator, {.poses = 60, .seed = 7}, folder.path, silent_progress());
  const auto recorded = open_source(folder.path.string());
  return evaluate_archive(archive, *recorded, Split::train, {}, silent_progress(), Detail::quality);
}

bool mentions(const std::vector<std::string>& sentences, const std::string& part) {
  for (const std::string& sentence : sentences)
    if (contains(sentence, part)) return true;
  return false;
}

}  // namespace

TEST_CASE("faces of an ordinary size are not scaled, others to a diagonal of 1 to 2") {
  Mesh mesh{{0, 0, 0, 1, 0, 0}, {}, {}};
  const struct {
    float length;
    int exponent;
  } cases[] = {{1, 0}, {0.001f, 0}, {1e6f, 0}, {0.0009f, 11}, {1.1e6f, -20}, {1e-20f, 67}, {1e20f, -66}};
  for (const auto& size : cases) {
    mesh.points[3] = size.length;
    const int exponent = scale_exponent(mesh);
    CHECK(exponent == size.exponent);
    if (exponent == 0) continue;
    const double diagonal = scaled(mesh, exponent).diagonal();
    CHECK(diagonal >= 1);
    CHECK(diagonal < 2);
    CHECK(scaled(scaled(mesh, exponent), -exponent).points == mesh.points);
  }
}

TEST_CASE("a tiny or gigantic face is baked as well as one of an ordinary size, in its own units") {
  for (const std::string recipe : {"linear", "hero", "paper"}) {
    CAPTURE(recipe);
    const auto sheet = open_hostile_rig("");
    const Baked usual = bake_quickly(*sheet, recipe);
    const double ordinary = errors_on(usual.archive, *sheet).total.rms;
    for (const char* fault : {"tiny", "gigantic"}) {
      CAPTURE(fault);
      const auto rig = open_hostile_rig(fault);
      const Baked baked = bake_quickly(*rig, recipe);
      CHECK(baked.warnings.size() == usual.warnings.size());
      verify_archive(baked.archive);
      const PackedModel model = archive::read_archive(baked.archive).model;
      CHECK(model.rest.diagonal() == doctest::Approx(rig->rest().diagonal()).epsilon(1e-4));
      const EvalReport report = errors_on(baked.archive, *rig);
      CHECK(report.diagonal == rig->rest().diagonal());
      CHECK(report.total.rms < 1.5 * ordinary + 1e-6);
      CHECK(report.total.p99 <= report.total.max);
      CHECK(std::isfinite(report.quality->normal_rms));
    }
  }
}

TEST_CASE("methods are compared on a tiny face, whose archives and recording are in its own units") {
  const auto rig = open_hostile_rig("tiny");
  const WorkFolder folder;
  const CompareReport report = compare(*rig, {"linear"}, quick(folder, "linear"), silent_progress());
  REQUIRE(!report.methods.empty());
  CHECK(report.diagonal == rig->rest().diagonal());
  CHECK(report.recorded->rest().points == rig->rest().points);
  CHECK(report.methods[0].locality->largest < 1e-3);
  const EvalReport again =
      evaluate_archive(report.methods[0].archive, *report.recorded, Split::test, {}, silent_progress());
  CHECK(again.total.rms == doctest::Approx(report.methods[0].independent.total.rms).epsilon(1e-6));
}

TEST_CASE("a rig that answers differently each time is named, and one that does not is not") {
  for (const bool noisy : {false, true}) {
    const auto rig = open_hostile_rig(noisy ? "noise" : "");
    const Baked baked = bake_quickly(*rig, "linear");
    REQUIRE(baked.repeatability);
    CHECK(baked.repeatability->poses == 16);
    const std::string certificate = archive::read_archive(baked.archive).text.certificate;
    CHECK(contains(certificate, "\"warnings\"") == noisy);
    CHECK(mentions(baked.warnings, "does not repeat itself") == noisy);
    CHECK(mentions(baked.stats.notes, "does not repeat itself") == noisy);
    if (noisy) {
      CHECK(baked.repeatability->max > 6e-4);
      CHECK(baked.repeatability->max < 4e-3);
      CHECK(baked.repeatability->rms > 1e-4);
    } else {
      CHECK(baked.repeatability->max == 0);
    }
  }
}

TEST_CASE("poses evaluated again count against no budget, so that they always are") {
  const auto noisy = open_hostile_rig("noise");
  const Baked baked = bake_quickly(*noisy, "linear", 150);
  CHECK(baked.asked <= 150);
  REQUIRE(baked.repeatability);
  CHECK(baked.repeatability->poses == 16);
  const auto rig = open_hostile_rig("");
  RigEvaluator evaluator(*rig);
  MemorySource recorded(6, 8, [](const float*, std::span<float>) {});
  recorded.add_clip("poses", ClipKind::dense, Split::train, 40, 0.5f, 1);
  for (float& value : recorded.edit_clip(0).controls) value = std::abs(value);
  const PoseSet poses(recorded, [](const Clip&) { return true; });
  CHECK(measure_repeatability(poses, evaluator, silent_progress()).poses == 16);
  CHECK(evaluator.requested() == 0);
  CHECK(evaluator.evaluated() == 16);
}

TEST_CASE("a face that is worse than its rest mesh is written with a warning in its certificate") {
  // At the end of its range a control throws all vertices far away, which a linear shape does everywhere.
  MemorySource source(
      3, 8,
      [](const float* c, std::span<float> points) {
        for (std::size_t i = 0; i < points.size(); ++i) points[i] += 0.1f * c[0] + (c[1] > 0.999f ? 50.0f : 0.0f);
      },
      true);
  const Baked baked = bake_quickly(source, "linear");
  CHECK(mentions(baked.warnings, "the face is worse than its rest mesh"));
  CHECK(contains(archive::read_archive(baked.archive).text.certificate, "worse than its rest mesh"));
  const auto sheet = open_hostile_rig("");
  CHECK_FALSE(mentions(bake_quickly(*sheet, "linear").warnings, "rest mesh"));
}

}  // namespace test_hostile_rigs
