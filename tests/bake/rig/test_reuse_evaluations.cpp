// Rigs that have changed since they were evaluated: resuming refuses them, and what still holds is reused.
#include "bake/rig/reuse_evaluations.h"

#include <cmath>

#include "bake/rig/changed_rig.h"
#include "bake_test_support.h"
#include "base/random.h"
#include "memory_source.h"
#include "watched_progress.h"

namespace test_reuse_evaluations {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::size_t width = 6, side = 6, size = 3 * side * side;

enum class Edit { none, control2, negative_control0, pair, noise };

struct EditedRig final : MemorySource {
  explicit EditedRig(Edit edit = Edit::none, std::string version = "1")
      : MemorySource(
            width, side, [this](const float* c, std::span<float> points) { move(c, points); }, true),
        edit_(edit),
        version_(std::move(version)) {}
  EditedRig(const EditedRig&) = delete;  // its formula points to it
  bool thread_safe() const override { return false; }
  std::string version() const override { return version_; }
  std::size_t evaluated = 0;

 private:
  void move(const float* c, std::span<float> points) {
    ++evaluated;
    for (std::size_t control = 0; control < width; ++control)
      points[3 * (4 * control + 1) + 1] += c[control] + 0.1f * c[control] * c[(control + 1) % width];
    if (edit_ == Edit::control2) points[3 * 9 + 2] += 0.05f * c[2];
    if (edit_ == Edit::negative_control0) points[3 * 9 + 2] += 0.05f * std::min(c[0], 0.0f);
    if (edit_ == Edit::pair) points[3 * 9 + 2] += 0.05f * c[1] * c[3];
    if (edit_ == Edit::noise) points[3 * 9 + 2] += 0.01f * random_.uniform();
  }
  Edit edit_;
  std::string version_;
  Random random_{3};
};

// Single controls at four values, further above rest than below it, and 300 poses of a few.
std::vector<float> asked_before() {
  std::vector<float> poses;
  for (std::size_t c = 0; c < width; ++c)
    for (const float value : {-0.75f, -0.5f, 0.5f, 1.0f}) {
      std::vector<float> pose(width);
      pose[c] = value;
      poses.insert(poses.end(), pose.begin(), pose.end());
    }
  Random random(8);
  for (std::size_t i = 0; i < 300 * width; ++i)
    poses.push_back(random.uniform() < 0.35f ? random.uniform(-1.0f, 1.0f) : 0.0f);
  return poses;
}

// The work folder of a bake of the rig without edits.
void evaluate_before(const std::filesystem::path& work, Edit edit = Edit::none) {
  EditedRig rig(edit, "0");
  EvaluationCache cache(work / "rig.evaluations", identity_of(rig));
  const std::vector<float> poses = asked_before();
  std::vector<float> points(size);
  for (std::size_t i = 0; i < poses.size(); i += width) {
    rig.evaluate(std::span(poses).subspan(i, width), 1, points);
    cache.store(std::span(poses).subspan(i, width), points);
  }
  cache.flush();
}

struct Reused {
  std::string notes;
  std::size_t evaluated = 0, poses = 0, without_control2 = 0;
};

// Reuses what an unchanged rig answered for one with this edit. Whatever is reused must be what the rig gives now.
Reused reuse(Edit edit) {
  const Folder folder;
  evaluate_before(folder / "old");
  EditedRig rig(edit), truth(edit);
  Notes notes;
  RigEvaluator evaluator(rig);
  CHECK(reuse_evaluations(evaluator, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, notes));
  CHECK_FALSE(std::filesystem::exists(folder / "new/rig.evaluations.asked"));
  Reused reused{notes.all, rig.evaluated};
  CHECK_FALSE(reuse_evaluations(evaluator, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, notes));
  CHECK(rig.evaluated == reused.evaluated);

  EvaluationCache cache(folder / "new/rig.evaluations", identity_of(rig));
  std::vector<float> pose(width), points(size), expected(size);
  for (reused.poses = 0; reused.poses < cache.record_count(); ++reused.poses) {
    REQUIRE(cache.read(reused.poses, pose, points));
    truth.evaluate(pose, 1, expected);
    REQUIRE(points == expected);
    reused.without_control2 += pose[2] == 0;
  }
  return reused;
}

}  // namespace

TEST_CASE("all evaluations of a rig that answers as before are reused, and are free") {
  const Folder folder;
  evaluate_before(folder / "old");
  EditedRig rig;
  Notes notes;
  RigEvaluator first(rig);
  CHECK(reuse_evaluations(first, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, notes));
  CHECK(first.requested() == 0);
  CHECK(rig.evaluated >= width + 32);
  CHECK(rig.evaluated < width + 32 + 12);
  CHECK(contains(notes.all, "of 324 evaluations 324 are reused and 0 dropped"));
  CHECK(contains(notes.all, "no control has changed"));

  const std::size_t before = rig.evaluated;
  RigEvaluator evaluator(rig, {}, folder / "new/rig.evaluations");
  const EvaluationBudget budget(evaluator, 1);
  const std::vector<float> poses = asked_before();
  std::vector<float> points(324 * size);
  evaluator.evaluate_cached(poses, 324, points);
  CHECK(evaluator.requested() == 0);
  CHECK(rig.evaluated == before);
}

TEST_CASE("poses of a control that has changed are dropped, all others are reused") {
  const Reused reused = reuse(Edit::control2);
  CHECK(contains(reused.notes, "; changed: \"control2\", at vertex 9 by 0.00"));
  CHECK_FALSE(contains(reused.notes, "control1"));
  const std::vector<float> poses = asked_before();
  std::size_t without = 0;
  for (std::size_t i = 2; i < poses.size(); i += width) without += poses[i] == 0;
  CHECK(reused.without_control2 == without);
  CHECK(reused.poses < without + width);  // and what was evaluated of control 2
}

TEST_CASE("a control that has changed where its furthest pose does not show it is found by poses of several") {
  const Reused reused = reuse(Edit::negative_control0);
  CHECK(contains(reused.notes, "; changed: \"control0\", at vertex 9 by "));
  CHECK(reused.poses > 150);
}

TEST_CASE("everything is dropped where no single control explains what has changed") {
  const Reused reused = reuse(Edit::pair);
  CHECK(contains(reused.notes, " 0 are reused and 324 dropped"));
  CHECK(contains(reused.notes, "no single control explains why pose "));
  CHECK_MESSAGE(reused.poses < 150, reused.notes);  // of which some 80 are single controls
  CHECK(reused.poses <= reused.evaluated);
}

TEST_CASE("a rig that does not repeat itself is compared within what lies between its own answers") {
  const Folder folder;
  evaluate_before(folder / "old", Edit::noise);
  EditedRig rig(Edit::noise);
  Notes notes;
  RigEvaluator evaluator(rig);
  CHECK(reuse_evaluations(evaluator, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, notes));
  CHECK(contains(notes.all, "of 324 evaluations 324 are reused"));
}

TEST_CASE("reusing goes on after an interruption without evaluating again") {
  const Folder folder;
  evaluate_before(folder / "old");
  EditedRig rig(Edit::control2);
  const auto run = [&](Progress& progress) {
    RigEvaluator evaluator(rig, {.threads = 1, .progress = &progress});
    return reuse_evaluations(evaluator, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, progress);
  };
  struct StopAfterFirstControls final : QuietProgress {
    void begin(Phase, std::string_view stage, std::uint64_t) override { stop = stage == "evaluating kept poses again"; }
    bool cancelled() const override { return stop; }
    bool stop = false;
  } stop;
  failure(Status::interrupted, [&] { run(stop); });
  const std::size_t before = rig.evaluated;
  CHECK(before >= width);
  CHECK_FALSE(std::filesystem::exists(folder / "new/rig.evaluations"));
  Notes notes;
  CHECK(run(notes));
  const Folder whole;
  evaluate_before(whole / "old");
  EditedRig same(Edit::control2);
  RigEvaluator evaluator(same, {.threads = 1, .progress = &notes});
  CHECK(reuse_evaluations(evaluator, whole / "old/rig.evaluations", whole / "new/rig.evaluations", 1, notes));
  CHECK(read_file(whole / "new/rig.evaluations") == read_file(folder / "new/rig.evaluations"));
  CHECK(rig.evaluated < same.evaluated + 32);
}

TEST_CASE("evaluations of a rig with another mesh or rest are dropped with a note that says why") {
  const Folder folder;
  evaluate_before(folder / "old");
  const auto dropped = [&](const std::function<void(EditedRig&)>& edit) {
    EditedRig rig;
    edit(rig);
    RigEvaluator evaluator(rig);
    Notes notes;
    CHECK_FALSE(reuse_evaluations(evaluator, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, notes));
    CHECK(rig.evaluated == 0);
    return notes.all;
  };
  CHECK(contains(dropped([](EditedRig& rig) { rig.edit_rest().polygon_corners[1] = 5; }),
                 "no evaluation is reused: the mesh has other polygons"));
  CHECK(contains(dropped([](EditedRig& rig) { rig.edit_rest().points[4] += 1; }),
                 "no evaluation is reused: the rest mesh lies elsewhere now"));
  std::filesystem::create_directory(folder / "empty");
  EditedRig rig;
  RigEvaluator evaluator(rig);
  Notes notes;
  CHECK_FALSE(reuse_evaluations(evaluator, folder / "empty/rig.evaluations", folder / "new/rig.evaluations", 1, notes));
  CHECK(contains(notes.all, "has no evaluations to reuse"));
  CHECK(contains(
      failure(Status::not_found,
              [&] { reuse_evaluations(evaluator, folder / "none/rig.evaluations", folder / "new/x", 1, notes); }),
      "no such folder"));
}

namespace {

// The rig of EditedRig with some of its controls, by number, or with one that is new: what is not there is at rest.
struct PartOfRig final : MemorySource {
  explicit PartOfRig(const std::vector<std::size_t>& numbers)
      : MemorySource(
            numbers.size(), side, [this](const float* c, std::span<float> points) { move(c, points); }, true),
        numbers_(numbers) {
    for (std::size_t i = 0; i < numbers.size(); ++i)
      edit_schema().controls[i].name = "control" + std::to_string(numbers[i]);
  }
  PartOfRig(const PartOfRig&) = delete;
  bool thread_safe() const override { return false; }
  std::string version() const override { return "1"; }
  std::size_t evaluated = 0;

 private:
  void move(const float* c, std::span<float> points) {
    ++evaluated;
    std::vector<float> all(width + 1);
    for (std::size_t i = 0; i < numbers_.size(); ++i) all[numbers_[i]] = c[i];
    points[3 * 2 + 2] += 0.3f * all[width];
    for (std::size_t control = 0; control < width; ++control)
      points[3 * (4 * control + 1) + 1] += all[control] + 0.1f * all[control] * all[(control + 1) % width];
  }
  std::vector<std::size_t> numbers_;
};

// Poses that were evaluated before of which `fits` holds.
std::size_t count_before(const std::function<bool(const float*)>& fits) {
  const std::vector<float> poses = asked_before();
  std::size_t count = 0;
  for (std::size_t i = 0; i < poses.size(); i += width) count += fits(&poses[i]);
  return count;
}

// Reuses what the whole rig answered; all that is reused must be what the rig gives now. The notes.
std::string reuse_in(PartOfRig& rig, std::size_t expected) {
  const Folder folder;
  evaluate_before(folder / "old");
  Notes notes;
  RigEvaluator evaluator(rig);
  CHECK(reuse_evaluations(evaluator, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, notes));
  EvaluationCache cache(folder / "new/rig.evaluations", identity_of(rig));
  CHECK(cache.record_count() == expected);
  std::vector<float> pose(rig.schema().control_count()), points(size), truth(size);
  for (std::uint64_t record = 0; record < cache.record_count(); ++record) {
    REQUIRE(cache.read(record, pose, points));
    rig.evaluate(pose, 1, truth);
    CHECK(points == truth);
  }
  return notes.all;
}

}  // namespace

TEST_CASE("of a rig with other controls, evaluations hold in which those that are gone were at rest") {
  const std::size_t without_3 = count_before([](const float* pose) { return pose[3] == 0; });
  REQUIRE(without_3 > 100);
  REQUIRE(without_3 < 324);
  PartOfRig fewer({0, 1, 2, 4, 5});
  const std::string gone = reuse_in(fewer, without_3);
  CHECK_MESSAGE(contains(gone, format("of 324 evaluations %zu are reused and %zu dropped", without_3, 324 - without_3)),
                gone);
  CHECK_MESSAGE(contains(gone, "; the control \"control3\" is gone; no control has changed"), gone);

  PartOfRig more({0, 1, 2, 3, 4, 5, 6});
  const std::string grown = reuse_in(more, 324);
  CHECK_MESSAGE(contains(grown, "of 324 evaluations 324 are reused and 0 dropped"), grown);
  CHECK_MESSAGE(contains(grown, "the control \"control6\" is new"), grown);

  PartOfRig moved({5, 4, 3, 2, 1, 0});
  CHECK(contains(reuse_in(moved, 324), "control 0 was \"control0\" and is \"control5\""));

  PartOfRig narrower({0, 1, 2, 3, 4, 5});
  narrower.edit_schema().controls[2].maximum = 0.5f;
  const std::size_t within = count_before([](const float* pose) { return pose[2] <= 0.5f; });
  CHECK(contains(reuse_in(narrower, within), "the range of the control \"control2\" was -1 to 1"));
}

TEST_CASE("a bake goes on where no earlier evaluation is one of the rig's poses") {
  const Folder folder;
  PartOfRig before({0, 1}), now({0, 2});
  EvaluationCache cache(folder / "old/rig.evaluations", identity_of(before));
  std::vector<float> points(size);
  for (const float value : {0.25f, 0.5f}) {
    const std::vector<float> pose = {0, value};
    before.evaluate(pose, 1, points);
    cache.store(pose, points);
  }
  cache.flush();
  RigEvaluator evaluator(now);
  Notes notes;
  const auto run = [&] {
    return reuse_evaluations(evaluator, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, notes);
  };
  CHECK_FALSE(run());
  CHECK_MESSAGE(contains(notes.all, "no evaluation is reused: the control \"control1\" is gone"), notes.all);
  EvaluationCache begun(folder / "new/rig.evaluations", identity_of(now));
  const std::vector<float> pose = {0.5f, 0};
  now.evaluate(pose, 1, points);
  begun.store(pose, points);
  begun.flush();
  CHECK_FALSE(run());
}

TEST_CASE("what was evaluated for a check of another version of the rig is none of this one's") {
  const Folder folder;
  evaluate_before(folder / "old");
  EditedRig other(Edit::pair, "2"), rig(Edit::none, "3");
  EvaluationCache stale(folder / "new/rig.evaluations.asked", identity_of(other));
  const std::vector<float> poses = asked_before();
  std::vector<float> points(size);
  other.evaluate(std::span(poses).first(width), 1, points);
  stale.store(std::span(poses).first(width), points);
  stale.flush();
  RigEvaluator evaluator(rig);
  Notes notes;
  CHECK(reuse_evaluations(evaluator, folder / "old/rig.evaluations", folder / "new/rig.evaluations", 1, notes));
  CHECK_MESSAGE(contains(notes.all, "of 324 evaluations 324 are reused"), notes.all);
}

TEST_CASE("kept evaluations are those of one version of a rig: another is refused, and one that answers otherwise") {
  const Folder folder;
  evaluate_before(folder / "work");
  const auto check = [&](EditedRig rig) {
    RigEvaluator evaluator(rig, {}, folder / "work/rig.evaluations");
    check_rig_unchanged(evaluator, 1, folder / "work", silent_progress());
    CHECK(evaluator.requested() == 0);
    return rig.evaluated;
  };
  CHECK(check(EditedRig(Edit::none, "0")) == 8);
  const std::string version = failure(Status::invalid_argument, [&] { check(EditedRig(Edit::none, "1")); });
  CHECK(contains(version, "the rig declared the version \"0\" and declares \"1\""));
  CHECK(contains(version, "--reuse"));
  struct MovedRig final : MemorySource {
    MovedRig()
        : MemorySource(
              width, side, [](const float*, std::span<float> points) { points[33] += 0.01f; }, true) {}
    std::string version() const override { return "0"; }
  } moved;
  RigEvaluator evaluator(moved, {}, folder / "work/rig.evaluations");
  const std::string otherwise =
      failure(Status::invalid_argument, [&] { check_rig_unchanged(evaluator, 1, folder / "work", silent_progress()); });
  for (const char* part :
       {"evaluated again, it puts vertex ", " of pose ", "\"control", " of the diagonal (", "--reuse"})
    CHECK_MESSAGE(contains(otherwise, part), otherwise);
}

TEST_CASE("a rig that does not repeat itself may go on with what it answered") {
  const Folder folder;
  evaluate_before(folder / "work", Edit::noise);
  EditedRig rig(Edit::noise, "0");
  RigEvaluator evaluator(rig, {}, folder / "work/rig.evaluations");
  check_rig_unchanged(evaluator, 1, folder / "work", silent_progress());
  CHECK(rig.evaluated == 8 + 16);
}

}  // namespace test_reuse_evaluations
