#include "bake/analysis/rig_analysis.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <thread>

#include "bake/sampling/control_responses.h"
#include "base/file.h"
#include "base/status.h"
#include "memory_source.h"
#include "temporary_folder.h"
#include "watched_progress.h"

namespace test_analyse_rig {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 6, vertices = side * side;

// A rig of 6 controls in [0, 1], but the last two in [-1, 1]. Each moves a row of the grid, all of it or more:
// 0 straight; 1 with corners at .3 and .7; 2 straight; 3 straight; 4 turns its row; 5 straight, the same both ways.
// Together: 0 x 2 on row 0, min(2, 3) on row 1, 0 x 2 x 3 on row 2, and 0 x (tent of 1 at .3) on row 3.
void formula(const float* c, std::span<float> p) {
  const auto move = [&](std::size_t row, double x, double y, double z) {
    for (std::size_t v = row * side; v < (row + 1) * side; ++v) {
      const double amount = 1 + 0.1 * double(v % side);
      p[3 * v] += float(amount * x), p[3 * v + 1] += float(amount * y), p[3 * v + 2] += float(amount * z);
    }
  };
  const double tent = std::max(0.0, std::min(c[1] / 0.3, (0.7 - c[1]) / 0.4));
  move(0, c[0], 0, 0);
  move(3, 0, 0, c[0]);
  move(1, 0.5 * c[1], tent, 0.2 * std::max(0.0, c[1] - 0.7));
  move(3, 0, c[1], 0);
  move(0, 0, 0, 0.4 * c[2]);
  move(1, 0.3 * c[2], 0, 0);
  move(2, c[2], 0, 0);
  move(1, 0, 0, c[3]);
  move(2, 0, c[3], 0);
  move(4, std::sin(0.3 * c[4]), 1 - std::cos(0.3 * c[4]), 0);
  move(5, 0, 0.7 * c[5], 0);
  move(0, 0, 0.5 * c[0] * c[2], 0);
  move(1, 0, 0.4 * std::min(c[2], c[3]), 0);
  move(2, 0, 0, 0.6 * c[0] * c[2] * c[3]);
  move(3, 0.3 * c[0] * tent, 0, 0);
  // 0 has to reach row 2 for the triple to have a row in common.
  move(2, 0, 0, 0.1 * c[0]);
}

MemorySource make_rig() {
  MemorySource rig(6, side, formula, true);
  for (std::size_t c = 0; c < 4; ++c) rig.edit_schema().controls[c].minimum = 0;
  return rig;
}

double worst_error(MemorySource& rig, const SparseBlendshapes& base, const std::vector<float>& pose) {
  std::vector<float> points(3 * vertices);
  rig.evaluate(pose, 1, points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] -= rig.rest().points[i];
  base.add(pose, rig.schema().rest_pose(), 1, -1, points);
  double worst = 0;
  for (std::size_t i = 0; i < points.size(); i += 3)
    worst = std::max(worst, std::hypot(double(points[i]), points[i + 1], points[i + 2]));
  return worst / rig.rest().diagonal();
}

RigAnalysis analyse(Source& source, const AnalysisOptions& options = {}, Progress& progress = silent_progress()) {
  RigEvaluator rig(source);
  return analyse_rig(rig, options, progress);
}

RigAnalysis analyse_formula(const AnalysisOptions& options, int threads = 2) {
  MemorySource source = make_rig();
  RigEvaluator rig(source, {.threads = threads});
  return analyse_rig(rig, options, silent_progress());
}

std::size_t shapes_of_control(const RigAnalysis& analysis, std::uint32_t control) {
  return static_cast<std::size_t>(
      std::count_if(analysis.base.shapes.begin(), analysis.base.shapes.end(), [&](const SparseShape& shape) {
        std::uint32_t f = shape.feature;
        std::set<std::uint32_t> seen;
        std::vector<std::uint32_t> open = {f};
        while (!open.empty()) {
          const Feature feature = analysis.base.features[open.back()];
          open.pop_back();
          if (feature.kind >= Feature::Kind::product)
            open.insert(open.end(), {feature.first, feature.second});
          else
            seen.insert(feature.control);
        }
        return seen == std::set<std::uint32_t>{control};
      }));
}

// Takes a millisecond a pose, so that evaluations are cached.
struct SlowRig final : MemorySource {
  SlowRig() : MemorySource(make_rig()) {}
  void evaluate(std::span<const float> poses, std::size_t count, std::span<float> points) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(count));
    MemorySource::evaluate(poses, count, points);
    for (std::size_t i = 0; i < count; ++i) evaluated.emplace_back(poses.begin() + 6 * i, poses.begin() + 6 * (i + 1));
  }
  std::vector<std::vector<float>> evaluated;
};

}  // namespace

TEST_CASE("curves have a shape for every corner, and straight controls have one") {
  const RigAnalysis analysis = analyse_formula({});
  for (const std::uint32_t straight : {0u, 2u, 3u, 5u}) CHECK(shapes_of_control(analysis, straight) == 1);
  CHECK(analysis.linear_controls == 4);
  CHECK(shapes_of_control(analysis, 1) == 3);
  CHECK(shapes_of_control(analysis, 4) <= 4);  // a turn: powers hold both sides in fewer shapes than corners
  CHECK(analysis.curve_error <= 1e-4);
  MemorySource rig = make_rig();
  for (std::size_t c = 0; c < 6; ++c)
    for (const float value : {-1.0f, -0.61f, -0.3f, 0.07f, 0.15f, 0.3f, 0.42f, 0.7f, 0.9f, 1.0f}) {
      std::vector<float> pose(6);
      if (value < rig.schema().controls[c].minimum) continue;
      pose[c] = value;
      CHECK(worst_error(rig, analysis.base, pose) <= (c == 4 ? 1e-4 : 1e-6));
    }
}

TEST_CASE("products, minima and triples are found, and reproduce unseen poses") {
  const RigAnalysis analysis = analyse_formula({});
  std::set<std::vector<std::uint32_t>> found;
  for (std::size_t i = 0; i < analysis.correctives.size(); ++i) {
    found.insert(analysis.correctives[i].controls);
    CHECK(analysis.correctives[i].features.size() == 1);
    if (i > 0) CHECK(analysis.correctives[i].energy <= analysis.correctives[i - 1].energy);
  }
  CHECK(found == std::set<std::vector<std::uint32_t>>{{0, 1}, {0, 2}, {2, 3}, {0, 2, 3}});
  for (const Corrective& corrective : analysis.correctives)
    if (corrective.controls == std::vector<std::uint32_t>{2, 3})
      CHECK(analysis.base.features[corrective.features[0]].kind == Feature::Kind::minimum);
  MemorySource rig = make_rig();
  rig.add_clip("unseen", ClipKind::dense, Split::test, 50, 0.8f, 77);
  for (std::size_t f = 0; f < 50; ++f) {
    const auto first = rig.clips()[0].controls.begin() + static_cast<std::ptrdiff_t>(6 * f);
    CHECK(worst_error(rig, analysis.base, {first, first + 6}) <= 1e-4);
  }
}

TEST_CASE("motion shows the vertices a control moves, residual motion those where the base is not exact") {
  const RigAnalysis all = analyse_formula({}), curves = analyse_formula({.max_pairs = 0, .max_triples = 0});
  const auto moves = [](const std::vector<float>& motion, std::size_t control) {
    std::set<std::size_t> rows;
    for (std::size_t v = 0; v < vertices; ++v)
      if (motion[control * vertices + v] > 1e-5f) rows.insert(v / side);
    return rows;
  };
  REQUIRE(all.motion.size() == 6 * vertices);
  // Together with 2, control 0 moves no further rows; 3 reaches row 2 alone.
  CHECK(moves(all.motion, 0) == std::set<std::size_t>{0, 2, 3});
  CHECK(moves(all.motion, 1) == std::set<std::size_t>{1, 3});
  CHECK(moves(all.motion, 4) == std::set<std::size_t>{4});
  CHECK(moves(curves.residual_motion, 0) == std::set<std::size_t>{0, 2, 3});
  CHECK(moves(curves.residual_motion, 3) == std::set<std::size_t>{1, 2});
  CHECK(moves(curves.residual_motion, 5).empty());
  CHECK(moves(all.residual_motion, 0).empty());
  CHECK(moves(all.residual_motion, 2).empty());
  CHECK(curves.correctives.empty());
}

TEST_CASE("an analysis is the same for any number of threads") {
  const RigAnalysis one = analyse_formula({}, 1), two = analyse_formula({}, 2);
  CHECK(one.rig_calls == two.rig_calls);
  CHECK(one.motion == two.motion);
  CHECK(one.residual_motion == two.residual_motion);
  REQUIRE(one.base.shapes.size() == two.base.shapes.size());
  for (std::size_t s = 0; s < one.base.shapes.size(); ++s) {
    CHECK(one.base.shapes[s].feature == two.base.shapes[s].feature);
    CHECK(one.base.shapes[s].vertices == two.base.shapes[s].vertices);
    CHECK(one.base.shapes[s].offsets == two.base.shapes[s].offsets);
  }
}

TEST_CASE("an analysis of a slow rig that was interrupted evaluates no pose twice") {
  struct Impatient final : test::QuietProgress {
    bool cancelled() const override { return rig->evaluated.size() > 200; }
    const SlowRig* rig;
  };
  const test::Folder folder;
  const std::filesystem::path cache = folder / "evaluations";
  const RigAnalysis whole = analyse_formula({});
  const auto analyse_again = [&] {
    SlowRig rig;
    RigEvaluator evaluator(rig, {.threads = 1}, cache);
    const RigAnalysis analysis = analyse_rig(evaluator, {}, silent_progress());
    CHECK(analysis.rig_calls == whole.rig_calls);
    CHECK(evaluator.evaluated() == rig.evaluated.size());
    CHECK(analysis.residual_motion == whole.residual_motion);
    REQUIRE(analysis.base.shapes.size() == whole.base.shapes.size());
    CHECK(analysis.base.shapes.back().offsets == whole.base.shapes.back().offsets);
    return rig.evaluated;
  };

  SlowRig rig;
  Impatient progress;
  progress.rig = &rig;
  RigEvaluator evaluator(rig, {.threads = 1}, cache);
  CHECK_THROWS_AS(analyse_rig(evaluator, {}, progress), Error);
  const std::size_t done = rig.evaluated.size();
  REQUIRE(done > 200);
  REQUIRE(done < whole.rig_calls);
  const std::vector<std::vector<float>> others = analyse_again();
  CHECK(done + others.size() <= whole.rig_calls + 1);  // and the pose at rest, which is not counted
  std::set<std::vector<float>> distinct(rig.evaluated.begin(), rig.evaluated.end());
  distinct.insert(others.begin(), others.end());
  CHECK(distinct.size() == done + others.size());
  CHECK(analyse_again().empty());
  std::vector<std::byte> bytes = read_file(cache);
  bytes[bytes.size() / 2] ^= std::byte{1};
  write_file(cache, bytes);
  CHECK(analyse_again().size() == 1);
  CHECK(analyse_again().empty());
}

TEST_CASE("the analysis evaluates no single control that sampling has evaluated") {
  const test::Folder folder;
  SlowRig alone, shared;
  RigEvaluator by_itself(alone, {.threads = 1}, folder / "alone"), after(shared, {.threads = 1}, folder / "shared");
  const RigAnalysis expected = analyse_rig(by_itself, {}, silent_progress());
  const ControlResponses responses(after, 0, silent_progress());
  const std::size_t sampled = shared.evaluated.size();
  CHECK(sampled == 6 * ControlResponses::most_values);
  const RigAnalysis analysis = analyse_rig(after, {}, silent_progress());
  const std::set<std::vector<float>> known(shared.evaluated.begin(),
                                           shared.evaluated.begin() + std::ptrdiff_t(sampled));
  const auto in_both = static_cast<std::size_t>(std::count_if(alone.evaluated.begin(), alone.evaluated.end(),
                                                              [&](const auto& pose) { return known.count(pose) > 0; }));
  CHECK(in_both >= 6 * (ControlResponses::most_values - 1));  // of every control, all values but rest
  CHECK(shared.evaluated.size() - sampled == alone.evaluated.size() - in_both);
  CHECK(analysis.rig_calls == expected.rig_calls - (in_both - 1));  // the pose at rest is not counted
  CHECK(analysis.motion == expected.motion);
  CHECK(analysis.residual_motion == expected.residual_motion);
}

TEST_CASE("dense poses judge what has been found so far") {
  MemorySource rig = make_rig();
  test::Notes notes;
  analyse(rig, {}, notes);
  const auto rms_of = [&](const char* stage) {
    double rms = -1;
    const std::size_t line = notes.all.find(stage), number = notes.all.find("active: ", line);
    REQUIRE(line != std::string::npos);
    REQUIRE(std::sscanf(notes.all.c_str() + number, "active: %lf of the diagonal", &rms) == 1);
    return rms;
  };
  CAPTURE(notes.all);
  const double curves = rms_of("activation curves");
  CHECK(curves < 0.1);
  CHECK(rms_of("correctives of 2 controls") < 0.5 * curves);
}

TEST_CASE("a budget is kept, and what it leaves out is noted") {
  const std::uint64_t plenty = analyse_formula({}).rig_calls;
  for (const std::uint64_t budget : {8u, 60u, 150u, 300u}) {
    MemorySource rig = make_rig();
    test::Notes notes;
    AnalysisOptions options;
    options.rig_budget = budget;
    const RigAnalysis analysis = analyse(rig, options, notes);
    CHECK(analysis.rig_calls <= budget);
    CHECK(analysis.rig_calls < plenty);
    CHECK(notes.all.find("budget") != std::string::npos);
    std::vector<float> pose(6);
    pose[5] = 1;
    CHECK(worst_error(rig, analysis.base, pose) <= 1e-6);  // ends of ranges come first
  }
}

TEST_CASE("a corrective of four controls is found by way of three") {
  const auto four = [](const float* c, std::span<float> p) {
    for (std::size_t v = 0; v < vertices; ++v) {
      p[3 * v] += c[0] + c[1] * c[2];
      p[3 * v + 1] += c[2] + c[3] + 0.5f * c[0] * c[1] * c[2];
      p[3 * v + 2] += c[1] + 0.5f * c[0] * c[1] * c[2] * c[3];
    }
  };
  MemorySource rig(4, side, four, true);
  for (Control& control : rig.edit_schema().controls) control.minimum = 0;
  const RigAnalysis analysis = analyse(rig);
  std::set<std::vector<std::uint32_t>> found;
  for (const Corrective& corrective : analysis.correctives) found.insert(corrective.controls);
  CHECK(found == std::set<std::vector<std::uint32_t>>{{1, 2}, {0, 1, 2}, {0, 1, 2, 3}});
  CHECK(worst_error(rig, analysis.base, {0.7f, 0.4f, 0.9f, 0.6f}) < 1e-6);
}

TEST_CASE("a recording cannot be analysed live, and a rig's failure names the controls") {
  MemorySource recording(6, side, formula, false);
  CHECK_THROWS_AS(analyse(recording), Error);
  struct FailingRig final : MemorySource {
    FailingRig() : MemorySource(6, side, formula, true) {}
    void evaluate(std::span<const float> poses, std::size_t count, std::span<float> points) override {
      for (std::size_t i = 0; i < count; ++i)
        if (poses[6 * i + 3] > 0.9f) throw PoseError(Status::not_finite, i, "vertex 7 is not a number");
      MemorySource::evaluate(poses, count, points);
    }
  } rig;
  try {
    analyse(rig);
    FAIL("a failing rig was analysed");
  } catch (const Error& error) {
    CHECK(error.status() == Status::not_finite);
    CHECK(std::string(error.what()) == "control \"control3\" at 1: vertex 7 is not a number");
  }
}

}  // namespace test_analyse_rig
