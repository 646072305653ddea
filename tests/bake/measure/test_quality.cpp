#include "bake/measure/quality.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "archive/writer.h"
#include "bake/compress/pack_model.h"
#include "bake/measure/evaluate.h"
#include "memory_source.h"

namespace test_quality {

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;

namespace {

using Points = std::vector<float>;

constexpr std::size_t side = 6;

// A grid whose left half is one part and whose right half another.
MemorySource grid() {
  return MemorySource(2, side, [](const float*, std::span<float>) {});
}
QualityBasis halves(const MemorySource& source) {
  FaceParts parts{{"left", "right"}, {}};
  for (std::size_t v = 0; v < source.rest().vertex_count(); ++v) parts.labels.push_back(v % side < side / 2 ? 0 : 1);
  return QualityBasis(source.rest(), source.schema(), parts);
}

// The points with every vertex of one half, or of both, moved along z.
Points moved(Points points, float way, bool left = true, bool right = true) {
  for (std::size_t v = 0; v < points.size() / 3; ++v)
    if (v % side < side / 2 ? left : right) points[3 * v + 2] += way;
  return points;
}

constexpr std::array<float, 2> at_rest = {0, 0};

// A face of linear blendshapes of the first two controls.
std::vector<std::byte> two_shapes(const Source& source, const std::vector<float>& shapes) {
  FaceModel model;
  model.schema = source.schema();
  model.rest = source.rest();
  model.network.features = {{Feature::Kind::identity, 0, 1, 0}, {Feature::Kind::identity, 1, 1, 0}};
  model.network.direct = {0, 1};
  model.basis = make_basis(static_cast<std::uint32_t>(model.rest.points.size()), 2, shapes);
  return write_archive(pack_model(model, {}), {});
}
// A face that never moves: its error is all of the source's motion.
std::vector<std::byte> still_archive(const Source& source) {
  return two_shapes(source, std::vector<float>(2 * source.rest().points.size()));
}

}  // namespace

TEST_CASE("a face turned by some degrees has normals that many degrees off") {
  const MemorySource source = grid();
  const QualityBasis basis = halves(source);
  const double angle = 3 * std::numbers::pi / 180;
  Points turned = source.rest().points;
  for (std::size_t v = 0; v < turned.size() / 3; ++v) {
    const double y = turned[3 * v + 1], z = turned[3 * v + 2];
    turned[3 * v + 1] = static_cast<float>(std::cos(angle) * y - std::sin(angle) * z);
    turned[3 * v + 2] = static_cast<float>(std::sin(angle) * y + std::cos(angle) * z);
  }
  QualitySums sums(basis);
  // Normals turn by the angle between the axis and them: flat ground makes that all of it.
  Points flat = source.rest().points, flat_turned = flat;
  for (std::size_t v = 0; v < flat.size() / 3; ++v) {
    flat[3 * v + 2] = 0;
    flat_turned[3 * v + 1] = static_cast<float>(std::cos(angle) * flat[3 * v + 1]);
    flat_turned[3 * v + 2] = static_cast<float>(std::sin(angle) * flat[3 * v + 1]);
  }
  sums.add_frame(at_rest, flat_turned, flat, false);
  CHECK(sums.figures().normal_rms == doctest::Approx(3).epsilon(1e-4));
  CHECK(sums.figures().normal_p99 == doctest::Approx(3).epsilon(0.017));
  QualitySums bumpy(basis);
  bumpy.add_frame(at_rest, turned, source.rest().points, false);
  CHECK(bumpy.figures().normal_rms < 3);
  CHECK(bumpy.figures().normal_rms > 2);
}

TEST_CASE("a step of the error where parts meet is a jump at the border and none inside") {
  const MemorySource source = grid();
  const QualityBasis basis = halves(source);
  CHECK(basis.borders.size() == side);
  CHECK(basis.borders.size() + basis.insides.size() == 2 * side * (side - 1));
  QualitySums sums(basis);
  const Points& truth = source.rest().points;
  sums.add_frame(at_rest, moved(truth, 0.25f, false, true), truth, false);
  const Quality quality = sums.figures();
  CHECK(quality.border_jump == doctest::Approx(0.25 / basis.diagonal));
  CHECK(quality.inside_jump < 1e-7);  // of rounding alone
  CHECK(quality.border_edges == side);
  REQUIRE(quality.regions.size() == 2);
  CHECK(quality.regions[0].mse == 0);
  CHECK(quality.regions[1].name == "right");
  CHECK(quality.regions[1].vertices == side * side / 2);
  CHECK(quality.regions[1].max == doctest::Approx(0.25 / basis.diagonal));
  CHECK(quality.vertex_rms.at(side - 1) == doctest::Approx(0.25 / basis.diagonal));
}

TEST_CASE("a border is compared with the insides of the parts that meet there") {
  const MemorySource source = grid();
  // Three stripes; only the first two meet where the error jumps, the third is without one.
  FaceParts parts{{"left", "middle", "right"}, {}};
  for (std::size_t v = 0; v < source.rest().vertex_count(); ++v)
    parts.labels.push_back(static_cast<std::uint32_t>(v % side / 2));
  REQUIRE(side >= 6);
  for (std::uint32_t& label : parts.labels) label = std::min(label, 2u);
  const QualityBasis basis(source.rest(), source.schema(), parts);
  QualitySums sums(basis);
  const Points& truth = source.rest().points;
  Points off = truth;
  const float steps[] = {0, 0.1f, 0.2f, 0.3f};  // the same from column to column up to the middle of it
  for (std::size_t v = 0; v < off.size() / 3; ++v) off[3 * v] += steps[std::min<std::size_t>(v % side, 3)];
  sums.add_frame(at_rest, off, truth, false);
  const Quality quality = sums.figures();
  // Half of the border edges join left and middle, with a jump of .1, half middle and right, with none.
  CHECK(quality.border_jump == doctest::Approx(0.1 / std::sqrt(2.0) / basis.diagonal).epsilon(1e-4));
  // Of a stripe's edges, side go across, with a jump of .1, and 2 (side - 1) along it, without; those of the right one
  // have none. Left and right stand for a quarter each, middle for half.
  const double stripe = 0.01 * side / (side + 2.0 * (side - 1));
  CHECK(quality.inside_jump == doctest::Approx(std::sqrt(0.75 * stripe) / basis.diagonal).epsilon(1e-4));
}

TEST_CASE("frame maxima of a region are those of its own vertices, whatever others do") {
  const MemorySource source = grid();
  const QualityBasis basis = halves(source);
  const Points& truth = source.rest().points;
  QualitySums sums(basis), later(basis);
  const auto add = [&](QualitySums& to, float left, float right) {
    to.add_frame(at_rest, moved(moved(truth, left, true, false), right, false, true), truth, false);
  };
  add(sums, 0.1f, 0);
  add(sums, 0.3f, 0);
  add(later, 0.2f, 0.8f);
  sums.append(later);
  const std::vector<RegionErrors> regions = sums.figures().regions;
  REQUIRE(regions.size() == 2);
  const double d = basis.diagonal;
  CHECK(regions[0].mfm == doctest::Approx(0.2 / d));
  CHECK(regions[0].p99fm == doctest::Approx(0.3 / d));
  CHECK(regions[1].mfm == doctest::Approx(0.8 / 3 / d));
  CHECK(regions[1].p99fm == doctest::Approx(0.8 / d));
  CHECK(regions[1].p99fm <= regions[1].max);
}

TEST_CASE("a face of one part has no border") {
  const MemorySource source = grid();
  const QualityBasis basis(source.rest(), source.schema(),
                           {{"face"}, std::vector<std::uint32_t>(source.rest().vertex_count())});
  QualitySums sums(basis);
  sums.add_frame(at_rest, moved(source.rest().points, 1, false, true), source.rest().points, false);
  CHECK(sums.figures().border_edges == 0);
  CHECK(sums.figures().border_jump == 0);
  CHECK(sums.figures().inside_jump > 0);
}

TEST_CASE("an error that alternates flickers, one that stays or drifts does not") {
  const MemorySource source = grid();
  const QualityBasis basis = halves(source);
  const Points& truth = source.rest().points;
  const auto jitter_of = [&](const auto& error, bool shot) {
    QualitySums sums(basis);
    for (int t = 0; t < 6; ++t) sums.add_frame(at_rest, moved(truth, error(t)), truth, shot);
    return sums.figures();
  };
  const Quality flicker = jitter_of([](int t) { return t % 2 ? 0.5f : -0.5f; }, true);
  CHECK(flicker.jitter == doctest::Approx(2 / basis.diagonal));
  CHECK(flicker.jitter_frames == 4);
  CHECK(jitter_of([](int) { return 0.5f; }, true).jitter < 1e-6);
  CHECK(jitter_of([](int t) { return 0.25f * static_cast<float>(t); }, true).jitter < 1e-6);
  CHECK(jitter_of([](int t) { return t % 2 ? 0.5f : -0.5f; }, false).jitter_frames == 0);
}

TEST_CASE("sums joined in order, with frames led in, are the sums of all frames") {
  const MemorySource source = grid();
  const QualityBasis basis = halves(source);
  const Points& truth = source.rest().points;
  const auto face = [&](int t) { return moved(truth, 0.1f * static_cast<float>((t * t) % 7), true, t % 3 == 0); };
  const auto pose = [](int t) { return std::array<float, 2>{t % 2 ? 0.9f : 0.1f, 0}; };
  QualitySums all(basis), joined(basis), second(basis);
  for (int t = 0; t < 9; ++t) {
    all.add_frame(pose(t), face(t), truth, true);
    if (t < 5) joined.add_frame(pose(t), face(t), truth, true);
    if (t == 3 || t == 4) second.add_warm_up(face(t), truth);
    if (t >= 5) second.add_frame(pose(t), face(t), truth, true);
  }
  joined.append(second);
  const Quality a = all.figures(), b = joined.figures();
  CHECK(a.jitter_frames == 7);
  CHECK(b.jitter_frames == 7);
  CHECK(a.jitter == doctest::Approx(b.jitter));
  CHECK(a.normal_rms == doctest::Approx(b.normal_rms));
  CHECK(a.border_jump == doctest::Approx(b.border_jump));
  CHECK(a.vertex_rms == b.vertex_rms);
  CHECK(all.frames().size() == joined.frames().size());
  REQUIRE(a.controls.size() == 1);  // the other one never goes so far
  CHECK(a.controls[0].name == "control0");
  CHECK(a.controls[0].all.frames == 4);
  CHECK(a.controls[0].all.mse == doctest::Approx(b.controls.at(0).all.mse));
}

TEST_CASE("an archive is measured the same for any number of threads, frame by frame") {
  MemorySource source(2, side, [](const float* controls, std::span<float> points) {
    for (std::size_t v = 0; v < points.size() / 3; ++v) points[3 * v + 2] += controls[0] * float(v % side);
  });
  source.add_clip("walk", ClipKind::shot, Split::test, 50, 1, 3);
  source.add_clip("heap", ClipKind::dense, Split::test, 20, 0.5f, 4);
  const std::vector<std::byte> archive = still_archive(source);
  const auto measure = [&](int threads) {
    return evaluate_archive(archive, source, Split::test, {.threads = threads}, silent_progress(), Detail::quality);
  };
  const EvalReport one = measure(1), two = measure(2);
  REQUIRE(one.quality);
  CHECK(one.quality->jitter == two.quality->jitter);
  CHECK(one.quality->normal_rms == two.quality->normal_rms);
  CHECK(one.quality->jitter_frames == 48);
  REQUIRE(one.clips.at(0).frames.size() == 50);
  REQUIRE(one.clips.at(1).frames.size() == 20);
  double squares = 0, flicker = 0, square_columns = 0;
  for (std::size_t x = 0; x < side; ++x) square_columns += double(x * x) / side;
  const double d = one.diagonal;
  const std::vector<float>& walk = source.clips()[0].controls;
  for (std::size_t t = 0; t < 50; ++t) {
    squares += one.clips[0].frames[t].mse;
    CHECK(one.clips[0].frames[t].max == doctest::Approx(std::abs(walk[2 * t]) * (side - 1) / d).epsilon(1e-4));
    if (t < 2) continue;
    const double second = double(walk[2 * t - 4]) - 2.0 * walk[2 * t - 2] + walk[2 * t];
    flicker += second * second * square_columns / 48 / (d * d);
  }
  CHECK(squares / 50 == doctest::Approx(one.clips[0].errors.mse).epsilon(1e-5));
  CHECK(one.quality->jitter == doctest::Approx(std::sqrt(flicker)).epsilon(1e-4));
  CHECK(one.quality->normal_p99 > one.quality->normal_rms);

  const std::vector<FrameOfClip> worst = worst_frames(one, source, 4);
  REQUIRE(worst.size() == 4);
  CHECK(worst[0].errors.max == doctest::Approx(one.total.max).epsilon(1e-5));
  for (std::size_t i = 1; i < worst.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      CHECK((worst[i].clip != worst[j].clip || std::abs(double(worst[i].frame) - double(worst[j].frame)) >= 12));
  CHECK_FALSE(evaluate_archive(archive, source, Split::test, {}, silent_progress()).quality);
}

TEST_CASE("the error of a control is that of what it moves, where others are off rest too") {
  // Control 0 moves the left half, which the archive gets right; control 1 the right one, which it does not.
  MemorySource source(2, side, [](const float* controls, std::span<float> points) {
    for (std::size_t v = 0; v < points.size() / 3; ++v)
      points[3 * v + 2] += v % side < side / 2 ? controls[0] : controls[1];
  });
  source.add_clip("alone", ClipKind::dense, Split::test, 3, 0, 1);
  source.add_clip("both", ClipKind::dense, Split::test, 4, 0, 1);
  for (std::size_t f = 0; f < 3; ++f) source.edit_clip(0).controls[2 * f + 1] = 1;
  std::fill(source.edit_clip(1).controls.begin(), source.edit_clip(1).controls.end(), 0.75f);
  std::vector<float> shapes(2 * source.rest().points.size());
  for (std::size_t v = 0; v < side * side; ++v) {
    const bool left = v % side < side / 2;
    shapes[(left ? 0 : source.rest().points.size()) + 3 * v + 2] = left ? 1 : 0.5f;
  }
  const Quality quality =
      *evaluate_archive(two_shapes(source, shapes), source, Split::test, {}, silent_progress(), Detail::quality)
           .quality;
  REQUIRE(quality.controls.size() == 2);
  const ControlQuality &sound = quality.controls[0], &poor = quality.controls[1];
  const double off = 0.75 * 0.5 / source.rest().diagonal();
  CHECK(sound.vertices == side * side / 2);
  CHECK(sound.all.frames == 4);
  CHECK(sound.all.max == doctest::Approx(off).epsilon(1e-3));
  CHECK(sound.combined.frames == 4);
  CHECK(sound.combined.max < 1e-4);
  CHECK(poor.all.frames == 7);
  CHECK(poor.combined.frames == 4);
  CHECK(poor.combined.max == doctest::Approx(off).epsilon(1e-3));
  CHECK(std::sqrt(poor.combined.mse) == doctest::Approx(off).epsilon(1e-3));
}

TEST_CASE("worst frames differ in pose, and first in place") {
  MemorySource source(2, side, [](const float* controls, std::span<float> points) {
    points[2] += controls[0];                  // the first vertex
    points[points.size() - 1] += controls[1];  // and the last
  });
  source.add_clip("alike", ClipKind::dense, Split::test, 60, 0, 1);
  source.add_clip("other", ClipKind::dense, Split::test, 40, 0, 1);
  for (std::size_t f = 0; f < 60; ++f) source.edit_clip(0).controls[2 * f] = 1 - 0.002f * float(f);
  source.edit_clip(0).controls[2 * 30] = -0.9f;  // another pose, the same vertex
  source.edit_clip(1).controls[2 * 20 + 1] = 0.5f;
  const EvalReport report =
      evaluate_archive(still_archive(source), source, Split::test, {}, silent_progress(), Detail::quality);
  const std::vector<FrameOfClip> worst = worst_frames(report, source, 3);
  REQUIRE(worst.size() == 3);
  CHECK(worst[0].clip == 0);
  CHECK(worst[0].frame == 0);
  CHECK(worst[0].errors.worst_vertex == 0);
  CHECK(worst[1].clip == 1);
  CHECK(worst[1].frame == 20);
  CHECK(worst[1].errors.worst_vertex == side * side - 1);
  CHECK(worst[2].frame == 30);
  CHECK(report.total.worst_vertex == 0);
}

}  // namespace test_quality
