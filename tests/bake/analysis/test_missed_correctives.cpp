#include "bake/analysis/live/missed_correctives.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bake/analysis/rig_analysis.h"
#include "bake/rig/rig_evaluator.h"
#include "base/status.h"
#include "memory_source.h"
#include "watched_progress.h"

namespace test_missed_correctives {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 12, vertices = side * side, controls = 48;

void move(std::span<float> p, std::size_t vertex, std::size_t axis, float amount) {
  p[3 * vertex + axis] += amount;
}

// Every control moves a vertex of its own, and four that all share. Of every fourth, the control after it moves its
// vertex too: pairs that are easily found. On the shared vertices act the triple {1, 6, 11} and the quad {2, 7, 12,
// 17}, of whose controls no fewer act together: correctives that no other leads to. `five`: and five controls together,
// which no corrective holds.
void formula(const float* c, std::span<float> p, bool five) {
  for (std::size_t k = 0; k < controls; ++k) {
    move(p, k, 0, 0.6f * c[k]);
    for (const std::size_t shared : {140u, 141u, 142u, 143u}) move(p, shared, k % 3, 0.1f * c[k]);
  }
  for (std::size_t k = 0; k + 1 < controls; k += 4) move(p, k, 1, 0.5f * c[k] * c[k + 1] + 0.1f * c[k + 1]);
  move(p, 140, 2, 0.8f * c[1] * c[6] * c[11]);
  move(p, 141, 1, 0.8f * c[2] * c[7] * c[12] * c[17]);
  if (five) move(p, 142, 1, 3 * c[3] * c[8] * c[13] * c[18] * c[23]);
}

MemorySource make_rig(bool five = false) {
  MemorySource rig(
      controls, side, [five](const float* c, std::span<float> p) { formula(c, p, five); }, true);
  for (Control& control : rig.edit_schema().controls) control.minimum = 0;
  return rig;
}

RigAnalysis analyse(MemorySource source, const AnalysisOptions& options, Progress& progress, int threads = 2) {
  RigEvaluator rig(source, {.threads = threads});
  return analyse_rig(rig, options, progress);
}

std::set<std::vector<std::uint32_t>> beyond_pairs(const RigAnalysis& analysis) {
  std::set<std::vector<std::uint32_t>> found;
  for (const Corrective& corrective : analysis.correctives)
    if (corrective.controls.size() > 2) found.insert(corrective.controls);
  return found;
}

// The largest distance of the base from the rig over 500 random poses, over the diagonal.
double worst_error(MemorySource rig, const SparseBlendshapes& base) {
  rig.add_clip("unseen", ClipKind::dense, Split::test, 500, 0.6f, 77);
  const std::vector<float>& poses = rig.clips()[0].controls;
  std::vector<float> points(500 * 3 * vertices);
  rig.evaluate(poses, 500, points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] -= rig.rest().points[i % (3 * vertices)];
  base.add(poses, rig.schema().rest_pose(), 500, -1, points);
  double worst = 0;
  for (std::size_t i = 0; i < points.size(); i += 3)
    worst = std::max(worst, std::hypot(double(points[i]), points[i + 1], points[i + 2]));
  return worst / rig.rest().diagonal();
}

const std::set<std::vector<std::uint32_t>> hidden = {{1, 6, 11}, {2, 7, 12, 17}};

}  // namespace

TEST_CASE("a triple and a quad that no pair leads to are found with any seed") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    CAPTURE(seed);
    test::Notes notes;
    const RigAnalysis analysis = analyse(make_rig(), {.seed = seed}, notes);
    CHECK(beyond_pairs(analysis) == hidden);
    CHECK(analysis.correctives.size() == controls / 4 + hidden.size());
    CHECK(worst_error(make_rig(), analysis.base) < 1e-5);
    CHECK(notes.all.find(" missed correctives added") != std::string::npos);
    CHECK(notes.all.find(": 0 missed") == std::string::npos);
  }
}

TEST_CASE("what is left is said, with the controls it takes, if a fresh pose has them") {
  std::size_t named = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    test::Notes notes;
    const RigAnalysis analysis = analyse(make_rig(true), {.seed = seed}, notes);
    CHECK(beyond_pairs(analysis) == hidden);
    const std::string::size_type left = notes.all.find("of fresh poses left ");
    REQUIRE(left != std::string::npos);
    const std::string said = notes.all.substr(left, notes.all.find('\n', left) - left);
    CAPTURE(said);
    if (said.find("at most") != std::string::npos) continue;  // few poses have all five
    ++named;
    for (const char* control : {"control3\"", "control8\"", "control13\"", "and 2 more"})
      CHECK(said.find(control) != std::string::npos);
  }
  CHECK(named >= 1);
}

TEST_CASE("missed correctives are the same for any number of threads") {
  const RigAnalysis one = analyse(make_rig(), {}, silent_progress(), 1),
                    two = analyse(make_rig(), {}, silent_progress(), 2);
  CHECK(one.rig_calls == two.rig_calls);
  REQUIRE(one.base.shapes.size() == two.base.shapes.size());
  for (std::size_t s = 0; s < one.base.shapes.size(); ++s)
    CHECK(one.base.shapes[s].offsets == two.base.shapes[s].offsets);
}

TEST_CASE("looking for missed correctives keeps to a budget, and can be interrupted") {
  const std::uint64_t plenty = analyse(make_rig(), {}, silent_progress()).rig_calls;
  for (const std::uint64_t budget : {plenty - 1, plenty - 500, plenty / 2, std::uint64_t{60 * controls}}) {
    test::Notes notes;
    AnalysisOptions options;
    options.rig_budget = budget;
    CHECK(analyse(make_rig(), options, notes).rig_calls <= budget);
    CHECK(notes.all.find("missed correctives") != std::string::npos);
  }
  struct Impatient final : test::QuietProgress {
    void begin(Phase, std::string_view stage, std::uint64_t) override {
      stop = stop || stage.find("missed") < stage.size();
    }
    bool cancelled() const override { return stop; }
    bool stop = false;
  } progress;
  CHECK_THROWS_AS(analyse(make_rig(), {}, progress), Error);
}

}  // namespace test_missed_correctives
