#include "bake/measure/worst_vertex.h"

#include <doctest/doctest.h>

#include "archive/reader.h"
#include "base/random.h"
#include "toy_faces.h"

namespace test_worst_vertex {

using namespace fb;
using namespace fb::bake;

namespace {

// A sheet whose lower left corner goes where no face can follow when control 0 acts, by more with control 1.
void jumping_corner(const float* c, std::span<float> points) {
  linear_formula(c, points);
  const std::size_t corner = 7;
  points[3 * corner + 2] += 0.2f * std::sin(3000 * c[0]) * (1 + c[3]);
}

MemorySource face_with_clips(const MemorySource::Formula& formula) {
  MemorySource source = face_of(formula);
  source.edit_schema().controls[0].group = "mouth";
  source.add_clip("trained", ClipKind::dense, Split::train, 300, 0.6f, 1);
  source.add_clip("unseen", ClipKind::shot, Split::test, 60, 0.5f, 4);
  return source;
}

// Eight controls of which three touch something where all of them act far: a corner that few random poses reach.
void touching_formula(const float* c, std::span<float> points) {
  const float reached = std::max(0.0f, c[0] + c[1] + c[2] - 1.8f);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 8; ++k) points[i] += 0.3f * c[k] * std::sin(float(i * (k + 1)));
    points[i] += reached * std::cos(0.4f * float(i)) - 0.5f * reached * reached * std::sin(0.3f * float(i));
  }
}

// Frames of the eight controls in which the three act far.
std::vector<float> touching_frames(std::size_t frames, std::uint64_t seed) {
  std::vector<float> controls;
  for (std::size_t f = 0; f < frames; ++f) {
    Random random(seed, f);
    for (std::size_t k = 0; k < 8; ++k)
      controls.push_back(k < 3 ? random.uniform(0.6f, 1.0f) : random.uniform(0.0f, 0.2f));
  }
  return controls;
}

bool contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

// How far the worst vertex of unseen poses is off; the rig's unit is the centimetre.
std::string told(const Source& source, const Errors& unseen) {
  return format("the worst vertex of unseen poses is off by %.3g mm, %.3g %% of the diagonal",
                10 * unseen.max * source.rest().diagonal(), 100 * unseen.max);
}

}  // namespace

TEST_CASE("a bake names the worst vertex by frame, place and controls, and its certificate does not") {
  MemorySource source = face_with_clips(jumping_corner);
  const WorkFolder folder;
  const Baked baked = bake_face(source, options_in(folder, "linear"), silent_progress());
  REQUIRE(baked.independent);
  REQUIRE(baked.warnings.size() == 1);
  const std::string& warning = baked.warnings[0];
  CAPTURE(warning);
  const Errors& unseen = baked.independent->total;
  CHECK(unseen.worst_vertex == 7);
  CHECK(contains(warning, told(source, unseen).c_str()));
  CHECK(contains(warning, format("frame %zu of \"unseen\" at vertex 7 (", unseen.worst_frame).c_str()));
  CHECK(contains(warning, "lower left"));
  CHECK(contains(warning, "), where \"control"));
  CHECK(contains(warning, "More recorded poses of these controls together"));
  CHECK(contains(warning, "of poses trained on is off by") == (baked.dependency.max > unseen.max));
  CHECK_FALSE(contains(archive::read_archive(baked.archive).text.certificate, "worst vertex"));
}

TEST_CASE("what the warning advises for a live rig helps a variant") {
  const auto baked_with = [](std::vector<float> examples) {
    MemorySource rig(8, 8, touching_formula, true);
    rig.add_clip("unseen", ClipKind::shot, Split::test, 60, 0.5f, 4);
    rig.edit_clip(0).controls = touching_frames(60, 5);
    const WorkFolder folder;
    BakeOptions options = options_in(folder, "compact");
    options.use = Use::variant;
    options.rig_budget = 300;
    options.epochs = 60;
    options.examples = std::move(examples);
    return bake_face(rig, options, silent_progress());
  };
  const Baked before = baked_with({}), after = baked_with(touching_frames(40, 6));
  REQUIRE(before.warnings.size() == 1);
  CHECK(contains(before.warnings[0], "--poses-like, with control values of such motion"));
  CAPTURE(before.independent->total.max);
  CAPTURE(after.independent->total.max);
  CHECK(after.independent->total.max < 0.7 * before.independent->total.max);
  CHECK(after.independent->total.mfm < 0.7 * before.independent->total.mfm);
}

TEST_CASE("without clips to measure on, poses held back from training are the unseen ones") {
  MemorySource source = face_of(jumping_corner);
  source.add_clip("trained", ClipKind::dense, Split::train, 400, 0.6f, 1);
  const WorkFolder folder;
  BakeOptions options = options_in(folder, "compact");
  options.epochs = 2;
  const Baked baked = bake_face(source, options, silent_progress());
  CHECK_FALSE(baked.independent);
  REQUIRE(baked.held_back.total.frames > 0);
  REQUIRE(baked.warnings.size() == 1);
  CAPTURE(baked.warnings[0]);
  CHECK(contains(baked.warnings[0], told(source, baked.held_back.total).c_str()));
}

TEST_CASE("a face that is right everywhere has no worst vertex to name") {
  MemorySource source = face_with_clips(linear_formula);
  const WorkFolder folder;
  BakeOptions options = options_in(folder, "compact");
  options.epochs = 2;
  const Baked baked = bake_face(source, options, silent_progress());
  CHECK(baked.independent->total.max < worst_vertex_bound);
  CHECK(baked.warnings.empty());
}

TEST_CASE("controls are named by what they do to the vertex in that pose") {
  MemorySource source = face_with_clips(curved_formula);
  const WorkFolder folder;
  const Baked baked = bake_face(source, options_in(folder, "linear"), silent_progress());
  const PackedModel model = archive::read_archive(baked.archive).model;
  const FaceMap map(model, {});
  std::copy_n(source.schema().rest_pose().begin(), 4, source.edit_clip(1).controls.begin());
  source.edit_clip(1).controls[3] = 0.5f;
  const PoseSet poses(source, [](const Clip& clip) { return clip.split == Split::test; });
  const std::string one = describe_worst(model, map, poses, {0.01, 0, 12});
  CHECK(contains(one, "frame 0 of \"unseen\""));
  CHECK(contains(one, "where \"control3\" act"));
  CHECK_FALSE(contains(one, "control0"));
}

}  // namespace test_worst_vertex
