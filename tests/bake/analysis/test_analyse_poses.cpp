#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bake/analysis/rig_analysis.h"
#include "memory_source.h"
#include "watched_progress.h"

namespace test_analyse_poses {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 6, vertices = side * side, controls = 6;

// Each control in [0, 1] moves a row of the grid: 0 and 1 straight, 2 with a corner at 1/2, 3 to 5 straight. Controls 0
// and 1 share row 0 and have a product there; nothing else acts together.
void formula(const float* c, std::span<float> p) {
  const auto move = [&](std::size_t row, double x, double y, double z) {
    for (std::size_t v = row * side; v < (row + 1) * side; ++v)
      p[3 * v] += float(x), p[3 * v + 1] += float(y), p[3 * v + 2] += float((1 + 0.1 * double(v % side)) * z);
  };
  move(0, c[0], c[1], 0.6 * c[0] * c[1]);
  move(1, 0, c[1], 0);
  move(2, c[2], 0, std::min<double>(c[2], 0.5));
  move(3, 0, 0, c[3]);
  move(4, c[4], 0, 0);
  move(5, 0, 0.4 * c[5], 0);
}

// Controls below `alone` are recorded alone at eighths; then many together.
MemorySource make_recording(std::size_t alone, std::size_t together) {
  MemorySource source(controls, side, formula);
  for (Control& control : source.edit_schema().controls) control.minimum = 0;
  source.add_clip("alone", ClipKind::excitation, Split::train, 8 * alone, 0, 1);
  for (std::size_t i = 0; i < 8 * alone; ++i)
    source.edit_clip(0).controls[i * controls + i / 8] = static_cast<float>(i % 8 + 1) / 8;
  source.add_clip("together", ClipKind::dense, Split::train, together, 0.5f, 2);
  for (std::size_t f = 0; f < together; ++f) {  // at least two at once
    float* pose = source.edit_clip(1).controls.data() + f * controls;
    if (std::count(pose, pose + controls, 0.0f) + 1 >= std::ptrdiff_t(controls)) pose[4] = 0.3f, pose[5] = 0.6f;
  }
  source.add_clip("unseen", ClipKind::dense, Split::test, 40, 0.6f, 3);
  return source;
}

PoseSet training(MemorySource& source) {
  return PoseSet(source, [](const Clip& clip) { return clip.split == Split::train; });
}

// Largest distance of the base from the recording, over the diagonal.
double worst_error(MemorySource& source, const SparseBlendshapes& base, std::size_t clip) {
  const std::size_t frames = source.clips()[clip].frames;
  std::vector<float> points(frames * 3 * vertices);
  source.read(clip, 0, frames, points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] -= source.rest().points[i % (3 * vertices)];
  base.add(source.clips()[clip].controls, source.schema().rest_pose(), frames, -1, points);
  double worst = 0;
  for (std::size_t i = 0; i < points.size(); i += 3)
    worst = std::max(worst, std::hypot(double(points[i]), points[i + 1], points[i + 2]));
  return worst / source.rest().diagonal();
}

// The root mean square distance of the base from the recording.
double rms_error(MemorySource& source, const SparseBlendshapes& base, std::size_t clip) {
  const std::size_t frames = source.clips()[clip].frames, size = source.rest().points.size();
  std::vector<float> points(frames * size);
  source.read(clip, 0, frames, points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] -= source.rest().points[i % size];
  base.add(source.clips()[clip].controls, source.schema().rest_pose(), frames, -1, points);
  double squares = 0;
  for (const float p : points) squares += double(p) * p;
  return std::sqrt(3 * squares / double(points.size()));
}

}  // namespace

TEST_CASE("recordings of single controls are fitted exactly, and pairs are found in the others") {
  MemorySource source = make_recording(controls, 400);
  const RigAnalysis analysis = analyse_poses(training(source), {}, {}, silent_progress());
  CHECK(analysis.rig_calls == 0);
  CHECK(analysis.linear_controls == 5);
  CHECK(worst_error(source, analysis.base, 0) < 1e-6);
  REQUIRE(analysis.correctives.size() == 1);
  CHECK(analysis.correctives[0].controls == std::vector<std::uint32_t>{0, 1});
  CHECK(worst_error(source, analysis.base, 2) < 1e-3);
  for (std::size_t c = 0; c < controls; ++c)
    for (std::size_t v = 0; v < vertices; ++v)
      CHECK((analysis.motion[c * vertices + v] > 1e-4f) == (v / side == c || (c == 1 && v / side == 0)));
}

TEST_CASE("controls never recorded alone are estimated, with a note") {
  MemorySource source = make_recording(2, 500);
  test::Notes notes;
  const RigAnalysis analysis = analyse_poses(training(source), {}, {}, notes);
  CHECK(worst_error(source, analysis.base, 0) < 1e-6);
  CHECK(worst_error(source, analysis.base, 2) < 5e-3);
  CHECK(notes.all.find("4 of 6 controls were never recorded alone") != std::string::npos);
  REQUIRE(!analysis.correctives.empty());
  CHECK(analysis.correctives[0].controls == std::vector<std::uint32_t>{0, 1});
}

TEST_CASE("a side of a control that was not recorded alone is fitted beside the one that was") {
  const auto two_sided = [](const float* c, std::span<float> p) {
    for (std::size_t v = 0; v < vertices; ++v) {
      p[3 * v] += c[0] > 0 ? c[0] : 0.2f * c[0];
      p[3 * v + 1] += c[1] + 0.5f * std::abs(c[1]);
    }
  };
  MemorySource source(2, side, two_sided);
  source.add_clip("alone", ClipKind::excitation, Split::train, 2, 0, 1);
  source.edit_clip(0).controls = {1, 0, 0, 1};
  source.add_clip("together", ClipKind::dense, Split::train, 200, 1, 2);
  source.add_clip("unseen", ClipKind::dense, Split::test, 40, 1, 3);
  const RigAnalysis analysis = analyse_poses(training(source), {}, {}, silent_progress());
  CHECK(worst_error(source, analysis.base, 0) < 1e-6);
  CHECK(worst_error(source, analysis.base, 2) < 1e-3);
}

TEST_CASE("residual motion is attributed to the controls that cause it") {
  MemorySource source = make_recording(controls, 400);
  AnalysisOptions options;
  options.max_pairs = 0;
  const RigAnalysis analysis = analyse_poses(training(source), options, {}, silent_progress());
  CHECK(analysis.correctives.empty());
  for (std::size_t c = 0; c < controls; ++c)
    for (std::size_t v = 0; v < vertices; ++v)
      CHECK((analysis.residual_motion[c * vertices + v] > 1e-3f) == (c < 2 && v / side == 0));
}

TEST_CASE("few poses do no harm, and threads do not matter") {
  MemorySource source = make_recording(0, 12);
  source.edit_clip(1).controls[5] = 0;
  test::Notes notes;
  const RigAnalysis analysis = analyse_poses(training(source), {}, {.threads = 1}, notes);
  CHECK(worst_error(source, analysis.base, 2) < worst_error(source, {}, 2));
  const RigAnalysis two = analyse_poses(training(source), {}, {.threads = 2}, silent_progress());
  REQUIRE(analysis.base.shapes.size() == two.base.shapes.size());
  for (std::size_t s = 0; s < two.base.shapes.size(); ++s)
    CHECK(analysis.base.shapes[s].offsets == two.base.shapes[s].offsets);
  CHECK(analysis.residual_motion == two.residual_motion);
}

TEST_CASE("with hardly more poses than shapes, the fit is regularised rather than dropped") {
  constexpr std::size_t many = 60, rows = 12;
  MemorySource source(many, rows, [](const float* c, std::span<float> p) {
    for (std::size_t k = 0; k < many; ++k)
      for (std::size_t v = 0; v < 4; ++v) p[3 * ((2 * k + v) % (rows * rows)) + k % 3] += c[k] + 0.2f * c[k] * c[k];
  });
  source.add_clip("together", ClipKind::dense, Split::train, 150, 0.2f, 2);
  source.add_clip("unseen", ClipKind::dense, Split::test, 100, 0.2f, 3);
  const RigAnalysis analysis = analyse_poses(training(source), {}, {}, silent_progress());
  const double base = rms_error(source, analysis.base, 1), rest = rms_error(source, {}, 1);
  MESSAGE("rms of the base ", base, ", of the rest mesh ", rest);
  CHECK(base < 0.13 * rest);  // 0.18 without
}

TEST_CASE("controls that never move are named") {
  MemorySource source = make_recording(1, 0);
  test::Notes notes;
  const RigAnalysis analysis = analyse_poses(training(source), {}, {}, notes);
  CHECK(notes.all.find("5 of 6 controls never leave rest in the recorded poses (\"control1\"") != std::string::npos);
  CHECK(worst_error(source, analysis.base, 0) < 1e-6);
  CHECK(std::all_of(analysis.motion.begin() + vertices, analysis.motion.end(), [](float m) { return m == 0; }));
}

}  // namespace test_analyse_poses
