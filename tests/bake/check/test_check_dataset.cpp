#include "bake/check/check_dataset.h"

#include <cmath>

#include "bake/check/rest_comparison.h"
#include "toy_dataset.h"

namespace test_check_dataset {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using namespace fb::test::toy_dataset;

namespace {

constexpr float not_a_number = NAN;

// A dataset with nothing wrong: a clip to train on that goes through both ranges, with the rest pose, and one to test.
struct GoodDataset : ToyDataset {
  static constexpr std::size_t many = 12;

  GoodDataset() {
    replace("\"kind\": \"regional\", \"split\": \"validation\"", "\"kind\": \"dense\"");
    replace(",\n             { \"name\": \"later\", \"controls\": \"later.controls.npy\" }", "");
    write_clip("talk", 0);
    write_clip("walk", 0.013f);
  }

  // Points are displaced by the controls.
  void write_clip(const std::string& name, float shift) {
    std::vector<float> values, points;
    for (std::size_t f = 0; f < many; ++f) {
      const float t = static_cast<float>(f) / (many - 1);
      const bool at_rest = f == 3;
      const float open = at_rest ? 0.25f : std::min(1.0f, t + shift), turn = at_rest ? 0 : 0.5f - t * (1 - shift);
      values.insert(values.end(), {open, turn});
      add_pose(points, open, turn);
    }
    bake::write_npy(folder / (name + ".controls.npy"), {many, 2}, values);
    bake::write_npy(folder / (name + ".points.npy"), {many, 4, 3}, points);
  }

  static void add_pose(std::vector<float>& points, float open, float turn) {
    for (const float x : {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f, 1.0f, 0.0f, 0.0f, 1.0f, 0.0f}) points.push_back(x);
    float* const pose = points.data() + points.size() - 12;
    pose[10] += 0.3f * (open - 0.25f);
    pose[8] += 0.2f * turn;
  }

  // All points of a clip, changed one by one.
  template <class Change>
  void change_points(const std::string& name, const Change& change) {
    const std::filesystem::path path = folder / (name + ".points.npy");
    std::vector<float> points(many * 12);
    NpyFile(path).read(0, many, points);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = change(i, points[i]);
    bake::write_npy(path, {many, 4, 3}, points);
  }

  DatasetFigures check() const {
    write_index();
    return check_dataset(folder.path(), {}, silent_progress());
  }
};

std::string all_of(const DatasetFigures& check) {
  std::string text;
  for (const Finding& fault : check.faults) text += "fault " + fault.kind + ": " + fault.text + "\n";
  for (const Finding& warning : check.warnings) text += "warning " + warning.kind + ": " + warning.text + "\n";
  return text;
}

// Whether a sentence of this kind says that.
bool found(const DatasetFigures& check, bool fault, const std::string& kind, const std::string& words) {
  for (const Finding& finding : fault ? check.faults : check.warnings)
    if (finding.kind == kind && contains(finding.text, words)) return true;
  return false;
}

}  // namespace

TEST_CASE("a good dataset has no faults, and its coverage is measured") {
  const GoodDataset good;
  const DatasetFigures check = good.check();
  CHECK_MESSAGE(check.bakeable, all_of(check));
  CHECK_MESSAGE(all_of(check).empty(), all_of(check));
  REQUIRE(check.active);
  CHECK(check.active->measured);
  CHECK(check.coverage);
  CHECK(check.controls[0].highest == 1);
  CHECK(check.controls[1].lowest == check.controls[1].minimum);
  CHECK(check.pair_shares.size() == 4);
  CHECK(check.pair_shares[1] > 0);
  CHECK(check.pair_shares[1] == check.pair_shares[2]);
  CHECK(check.vertex_motion.size() == 4);
  CHECK(check.vertex_motion[0] == 0);
  CHECK(check.vertex_motion[3] > 0.1f);
  REQUIRE(check.largest_frames.size() == 2);
  CHECK(check.clips[0].evaluated == GoodDataset::many);
}

TEST_CASE("all faults are found, not the first only") {
  GoodDataset wrong;
  wrong.replace("\"max\": 1,", "\"max\": 0,");
  wrong.replace("\"split\": \"test\"", "\"split\": \"exam\"");
  wrong.replace("] }", R"(], "sockets": 5 })");
  wrong.replace("\"clips\": [",
                R"("clips": [ { "name": "gone", "controls": "gone.controls.npy", "points": "gone.points.npy" },
    { "name": "short", "controls": "talk.controls.npy", "points": "short.points.npy" },
    { "name": "wide", "controls": "wide.controls.npy", "points": "walk.points.npy" },
    { "name": "parts", "controls": "talk.controls.npy", "points": ["a.npy", "talk.points.npy", "b.npy"] },)");
  write_npy(wrong.folder / "short.points.npy", {5, 4, 3}, counting(60, 0.01f));
  write_npy(wrong.folder / "wide.controls.npy", {12, 3}, counting(36, 0.01f));
  wrong.change_points("talk",
                      [](std::size_t i, float x) { return i == 4 * 12 + 7 || i == 9 * 12 + 1 ? not_a_number : x; });
  const DatasetFigures check = wrong.check();
  CAPTURE(all_of(check));
  CHECK_FALSE(check.bakeable);
  CHECK(found(check, true, "index", "split \"exam\" is no split"));
  CHECK(found(check, true, "index", "sockets is no list"));
  CHECK(found(check, true, "controls", "control \"open\": minimum 0 is not below maximum 0"));
  CHECK(found(check, true, "controls", "gone.controls.npy: no such file"));
  CHECK(found(check, true, "points", "clip \"short\" has 12 frames of controls and 5 frames of points"));
  CHECK(found(check, true, "controls", "wide.controls.npy: shape (12, 3) where (frames, 2) is needed"));
  CHECK(found(check, true, "points", "a.npy: no such file"));
  CHECK(found(check, true, "points", "b.npy: no such file"));
  CHECK(found(check, true, "not_finite",
              "clip \"talk\": 2 frames have points that are not finite: frame 4, vertex 2 is not finite, frame 9, "
              "vertex 0 is not finite"));
  CHECK_FALSE(check.active);
}

TEST_CASE("files that are no dataset are told, one fault each") {
  const Folder empty;
  CHECK(contains(failure(Status::not_found, [&] { check_dataset(empty / "none", {}, silent_progress()); }),
                 "is no folder"));
  CHECK(found(check_dataset(empty.path(), {}, silent_progress()), true, "index", "dataset.json"));
  std::ofstream(empty / "dataset.json") << "{ \"format\": ";
  const DatasetFigures broken = check_dataset(empty.path(), {}, silent_progress());
  CHECK(found(broken, true, "index", "is no JSON"));
  CHECK_FALSE(broken.bakeable);
}

TEST_CASE("frames too far away and controls that are not finite are faults") {
  GoodDataset wrong;
  wrong.change_points("talk", [](std::size_t i, float x) { return i == 7 * 12 + 3 ? 1e6f : x; });
  std::vector<float> values = counting(24, 0.01f);
  values[5] = not_a_number;
  values[6] = INFINITY;
  write_npy(wrong.folder / "walk.controls.npy", {12, 2}, values);
  const DatasetFigures check = wrong.check();
  CAPTURE(all_of(check));
  CHECK(found(check, true, "far", "frame 7, vertex 1 x = 1e+06 is more than"));
  CHECK(found(check, true, "not_finite", "2 values of controls are not finite: frame 2 \"turn\", frame 3 \"open\""));
}

TEST_CASE("frames that repeat are found") {
  GoodDataset stale;
  std::vector<float> points(12 * 12);
  NpyFile(stale.folder / "talk.points.npy").read(0, 12, points);
  std::copy_n(points.begin() + 5 * 12, 12, points.begin() + 6 * 12);
  std::copy_n(points.begin() + 5 * 12, 12, points.begin() + 7 * 12);
  write_npy(stale.folder / "talk.points.npy", {12, 4, 3}, points);
  const DatasetFigures check = stale.check();
  CAPTURE(all_of(check));
  CHECK(check.bakeable);
  CHECK(found(check, false, "repeated",
              "clip \"talk\": 2 frames have the points of another pose, as if the scene had not been evaluated after "
              "controls were set: frame 6 has the points of clip \"talk\", frame 5"));
}

TEST_CASE("a rig that remembers, poses that occur twice, and poses that leak are found") {
  GoodDataset other;
  std::filesystem::copy_file(other.folder / "talk.controls.npy", other.folder / "again.controls.npy");
  std::filesystem::copy_file(other.folder / "talk.points.npy", other.folder / "again.points.npy");
  other.replace("\"clips\": [",
                "\"clips\": [ { \"name\": \"again\", \"controls\": \"again.controls.npy\", \"points\": "
                "\"again.points.npy\" },");
  const DatasetFigures twice = other.check();
  CHECK_MESSAGE(found(twice, false, "duplicate",
                      "11 poses occur more than once: clip \"again\", frame 0, and clip "
                      "\"talk\", frame 0"),
                all_of(twice));
  CHECK_FALSE(found(twice, false, "unlike", ""));
  other.replace("\"name\": \"again\",", "\"name\": \"again\", \"split\": \"test\",");
  other.change_points("again", [](std::size_t i, float x) { return i % 12 == 10 ? x + 0.05f : x; });
  const DatasetFigures leaked = other.check();
  CHECK_MESSAGE(found(leaked, false, "leak", "11 poses to train on are poses to measure on too"), all_of(leaked));
  CHECK_MESSAGE(found(leaked, false, "unlike", "poses have other points each time"), all_of(leaked));
}

TEST_CASE("controls that are not used, move nothing or leave their range are told") {
  GoodDataset poor;
  std::vector<float> values, points;
  for (std::size_t f = 0; f < 12; ++f) {
    values.insert(values.end(), {0.25f, f < 6 ? 0.1f * static_cast<float>(f) : 0.0f});
    GoodDataset::add_pose(points, 0.25f, 0);
  }
  write_npy(poor.folder / "talk.controls.npy", {12, 2}, values);
  write_npy(poor.folder / "talk.points.npy", {12, 4, 3}, points);
  const DatasetFigures unused = poor.check();
  CAPTURE(all_of(unused));
  CHECK(found(unused, false, "unused", "1 controls are at rest in all poses to train on: \"open\""));
  CHECK(found(unused, false, "still", "1 controls, moved alone, move nothing: \"turn\""));
  values[2] = 1.5f;
  values[5] = -2;
  write_npy(poor.folder / "talk.controls.npy", {12, 2}, values);
  CHECK(found(poor.check(), false, "range",
              "2 values are outside the ranges of their controls, at worst \"turn\" = -2 (-0.5..0.5) in frame 2"));
}

TEST_CASE("points that do not fit the rest mesh are explained") {
  const auto warned = [](const auto& change) {
    GoodDataset wrong;
    std::vector<float> points(12 * 12);
    NpyFile(wrong.folder / "talk.points.npy").read(0, 12, points);
    for (std::size_t v = 0; v < points.size(); v += 3) change(points[v], points[v + 1], points[v + 2]);
    write_npy(wrong.folder / "talk.points.npy", {12, 4, 3}, points);
    const DatasetFigures check = wrong.check();
    CHECK(check.bakeable);
    for (const Finding& finding : check.warnings)
      if (finding.kind == "rest") return finding.text;
    return std::string();
  };
  CHECK(warned([](float&, float&, float&) {}).empty());
  const std::string scaled = warned([](float& x, float& y, float& z) { x *= 100, y *= 100, z *= 100; });
  CHECK_MESSAGE(
      contains(scaled, "clip \"talk\", frame 3: all controls are at rest, but the points are not the rest mesh"),
      scaled);
  CHECK_MESSAGE(contains(scaled, "they are 100 times as large, as if in other units"), scaled);
  const std::string turned = warned([](float&, float& y, float& z) {
    const float up = z;
    z = y;
    y = -up;
  });
  CHECK_MESSAGE(contains(turned, "turned by a quarter around x"), turned);
  const std::string moved = warned([](float& x, float&, float&) { x += 3; });
  CHECK_MESSAGE(contains(moved, "as if not in the mesh's own space"), moved);
}

TEST_CASE("vertices in another order and unlikely sizes are recognised") {
  const std::vector<float> rest = {0, 0, 0, 4, 0, 0, 4, 3, 0, 0, 3, 1}, other = {4, 3, 0, 0, 0, 0, 0, 3, 1, 4, 0, 0};
  CHECK(contains(explain_distance(rest, other, 1e-3), "vertices were in another order"));
  CHECK(suspicious_size(24, "cm") == std::nullopt);
  CHECK(suspicious_size(0.24, "m") == std::nullopt);
  CHECK(contains(suspicious_size(24, "m").value_or(""), "is 24 m across"));
  CHECK(contains(suspicious_size(0.2, "cm").value_or(""), "which is 0.002 m"));
  CHECK(suspicious_size(1e6, "furlongs") == std::nullopt);
}

TEST_CASE("what a plan lacks is said, and is a fault if there is nothing to train on") {
  GoodDataset plan;
  plan.replace("\"version\": 1,", "\"version\": 1, \"plan\": true,");
  std::filesystem::remove(plan.folder / "walk.points.npy");
  const DatasetFigures half = plan.check();
  CHECK(half.bakeable);
  CHECK_MESSAGE(found(half, false, "plan", "12 of 24 poses have no points yet, so that 1 clips are left out: \"walk\""),
                all_of(half));
  std::filesystem::rename(plan.folder / "talk.points.npy", plan.folder / "whole.npy");
  write_npy(plan.folder / "talk.000.points.npy", {5, 4, 3}, counting(60, 0.01f));
  const DatasetFigures none = plan.check();
  CHECK_FALSE(none.bakeable);
  CHECK_MESSAGE(found(none, false, "plan",
                      "19 of 24 poses have no points yet, so that 2 clips are left out: \"talk\" (5 of 12), \"walk\""),
                all_of(none));
  CHECK(found(none, true, "plan", "there is nothing to train on"));
  CHECK(none.clips[0].evaluated == 5);
}

}  // namespace test_check_dataset
