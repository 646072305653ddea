// The earlier systems: errors on a toy face, and robustness to unusual rigs.
#include <doctest/doctest.h>

#include <algorithm>

#include "archive/reader.h"
#include "bake/baselines/pose_correctives.h"
#include "bake/measure/evaluate.h"
#include "bake/pipeline/compare.h"
#include "bake/pipeline/recipe_table.h"
#include "base/file.h"
#include "base/status.h"
#include "toy_faces.h"
#include "watched_progress.h"

namespace test_baselines {

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;

namespace {

struct RecordedProgress final : test::QuietProgress {
  void begin(Phase, std::string_view stage, std::uint64_t) override { stages += std::string(stage) + "; "; }
  void note(std::string_view sentence) override { notes += std::string(sentence) + "; "; }
  bool did(const char* stage) const { return stages.find(stage) != std::string::npos; }
  std::string stages, notes;
};

Baked bake_quickly(Source& source, const WorkFolder& folder, const std::string& recipe, std::uint32_t epochs) {
  BakeOptions options = options_in(folder, recipe);
  options.work /= recipe;
  options.epochs = epochs;
  options.poses = 60;
  return bake_face(source, options, silent_progress());
}

}  // namespace

TEST_CASE("every earlier system beats linear blendshapes on a face with a corrective") {
  WorkFolder folder;
  MemorySource source = curved_face();
  const double linear = unseen_mse(bake_quickly(source, folder, "linear", 0).archive, source);
  const Baked kanyuk = bake_quickly(source, folder, "kanyuk2018", 0);
  CHECK(unseen_mse(kanyuk.archive, source) < 0.1 * linear);
  CHECK(kanyuk.stats.bones > 1);
  const Baked bailey = bake_quickly(source, folder, "bailey2018", 80);
  CHECK(unseen_mse(bailey.archive, source) < 0.5 * linear);
  CHECK(bailey.stats.bones > 1);
  CHECK(unseen_mse(bake_quickly(source, folder, "paper-gradients", 50).archive, source) < 0.5 * linear);
  CHECK(unseen_mse(bake_quickly(source, folder, "paper-tuned", 40).archive, source) < 0.2 * linear);
}

TEST_CASE("skinning with correctives is exact where one control is at its limit") {
  WorkFolder folder;
  MemorySource rig = face_of(curved_formula, true);
  const Baked baked = bake_quickly(rig, folder, "kanyuk2018", 0);
  MemorySource limits = face_of(curved_formula);
  limits.add_clip("limits", ClipKind::excitation, Split::test, 8, 0, 1);
  for (std::size_t i = 0; i < 8; ++i) {
    const Control& control = rig.schema().controls[i / 2];
    limits.edit_clip(0).controls[i * 4 + i / 2] = i % 2 ? control.maximum : control.minimum;
  }
  CHECK(evaluate_archive(baked.archive, limits, Split::test, {}, silent_progress()).total.max < 1e-4);
}

TEST_CASE("joints of matrices that are linear in shapes follow a face that such joints move") {
  WorkFolder folder;
  // Two halves of a sheet, which shear and stretch: "a" and "b" the left one, "c" the right one, both "a" and "c" more.
  MemorySource source(4, 24, [](const float* c, std::span<float> points) {
    for (std::size_t v = 0; v < points.size(); v += 3) {
      float* const p = &points[v];
      const bool left = v / 3 % 24 < 12;
      const float stretch = left ? c[0] : c[2], both = c[0] * c[2];
      p[0] += 0.1f * stretch * p[1];
      p[1] += left ? 0.2f * c[1] : 0.1f * both * p[0];
      p[2] += 0.3f * stretch;
    }
  });
  source.add_clip("poses", ClipKind::dense, Split::train, 400, 0.8f, 1);
  source.add_clip("unseen", ClipKind::dense, Split::test, 50, 0.8f, 2);
  const Baked baked = bake_quickly(source, folder, "kavan2024", 0);
  CHECK(baked.stats.bones >= 2);
  CHECK(unseen_mse(baked.archive, source) <
        0.2 * unseen_mse(bake_quickly(source, folder, "linear", 0).archive, source));
}

TEST_CASE("the corrective of two controls is found among all pairs") {
  MemorySource source(4, 6, [](const float* c, std::span<float> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] += std::max(c[1], 0.0f) * std::max(-c[2], 0.0f) * std::cos(float(i)) +
                   0.5f * std::min(std::max(c[0], 0.0f), std::max(c[3], 0.0f)) * std::sin(float(i));
  });
  source.add_clip("poses", ClipKind::dense, Split::train, 400, 0.8f, 1);
  const PoseSet poses(source, [](const Clip&) { return true; });
  std::vector<Feature> ramps;
  for (std::uint32_t c = 0; c < 4; ++c)
    for (const float side : {1.0f, -1.0f}) ramps.push_back({Feature::Kind::ramp, c, side, 0});
  const PoseCorrectives found =
      find_correctives(Displacements(poses), ramps, {.max_count = 2, .rounds = 2}, {}, silent_progress());
  REQUIRE(found.features.size() == 2);
  CHECK(found.features[0].kind == Feature::Kind::product);
  CHECK(found.features[0].first == 2);
  CHECK(found.features[0].second == 5);
  CHECK(found.features[1].kind == Feature::Kind::minimum);
  CHECK(found.features[1].first == 0);
  CHECK(found.features[1].second == 6);
  for (std::size_t i = 0; i < source.rest().points.size(); ++i) {
    CHECK(std::abs(found.shapes[i] - std::cos(float(i))) < 0.05f);
    CHECK(std::abs(found.shapes[source.rest().points.size() + i] - 0.5f * std::sin(float(i))) < 0.05f);
  }
}

TEST_CASE("every method bakes one control, no polygons, three poses and a live rig") {
  for (const std::string& recipe : recipe_names()) {
    CAPTURE(recipe);
    WorkFolder live_folder;
    MemorySource live = face_of(curved_formula, true, 6);
    CHECK(bake_quickly(live, live_folder, recipe, 1).poses >= 60);
    if (recipe == "untrained") continue;  // of a recording it makes nothing

    WorkFolder folder;
    MemorySource single(1, 6, [](const float* c, std::span<float> points) {
      for (std::size_t i = 0; i < points.size(); ++i) points[i] += c[0] * std::sin(float(i));
    });
    single.add_clip("poses", ClipKind::dense, Split::train, 40, 1, 1);
    CHECK(bake_quickly(single, folder, recipe, 1).archive.size() > 0);

    WorkFolder loose_folder;
    MemorySource loose = face_of(curved_formula, false, 6);
    loose.edit_rest().polygon_sizes.clear();
    loose.edit_rest().polygon_corners.clear();
    loose.add_clip("poses", ClipKind::dense, Split::train, 40, 0.6f, 1);
    CHECK(bake_quickly(loose, loose_folder, recipe, 1).poses == 40);

    WorkFolder few_folder;
    MemorySource few = face_of(curved_formula, false, 6);
    few.add_clip("poses", ClipKind::dense, Split::train, 3, 0.6f, 1);
    CHECK(bake_quickly(few, few_folder, recipe, 1).poses == 3);
  }
}

TEST_CASE("a repeated comparison bakes nothing again, unless the poses differ") {
  WorkFolder folder;
  MemorySource source = curved_face();
  RecordedProgress first, again, other;
  const std::vector<std::string> methods = {"linear", "paper"};
  BakeOptions options = options_in(folder);
  options.epochs = 1;
  const CompareReport before = compare(source, methods, options, first);
  CHECK(first.did("training"));
  const CompareReport after = compare(source, methods, options, again);
  CHECK_FALSE(again.did("training"));
  CHECK(again.notes.find("baked before") != std::string::npos);
  REQUIRE(after.methods.size() == before.methods.size());
  for (std::size_t m = 0; m < after.methods.size(); ++m) {
    CHECK(after.methods[m].independent.total.mse == before.methods[m].independent.total.mse);
    CHECK(after.methods[m].parameters == before.methods[m].parameters);
    CHECK(after.methods[m].archive == before.methods[m].archive);
  }
  std::filesystem::remove(folder.path / "linear.variant" / "face.fbk");
  write_file(folder.path / "paper.backlot" / "bake.json", std::string("{\"key\": 1"));
  RecordedProgress damaged;
  CHECK(compare(source, methods, options, damaged).methods.size() == before.methods.size());
  CHECK(damaged.did("training"));
  source.edit_clip(0).controls[4] = 0.125f;
  compare(source, methods, options, other);
  CHECK(other.did("training"));
}

TEST_CASE("a method that fails does not stop the others") {
  WorkFolder folder;
  MemorySource still(2, 4, [](const float*, std::span<float>) {});
  still.add_clip("dense", ClipKind::dense, Split::train, 30, 1, 1);
  still.add_clip("unseen", ClipKind::shot, Split::test, 30, 1, 2);
  RecordedProgress progress;
  const CompareReport report = compare(still, {"paper", "linear"}, options_in(folder), progress);
  REQUIRE(report.methods.size() == 1);
  CHECK(report.methods[0].name == "linear");
  REQUIRE(report.failures.size() == 1);
  CHECK(report.failures[0].name == "paper");
  CHECK(report.failures[0].reason.find("no pose moves any vertex") != std::string::npos);
  CHECK(progress.notes.find("\"paper\" failed") != std::string::npos);
  CHECK_THROWS_WITH(compare(still, {"paper"}, options_in(folder), silent_progress()),
                    doctest::Contains("no pose moves any vertex"));
}

}  // namespace test_baselines
