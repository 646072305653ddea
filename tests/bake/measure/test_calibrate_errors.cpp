#include "bake/measure/calibrate_errors.h"

#include <doctest/doctest.h>

#include <cmath>

#include "archive/reader.h"
#include "bake/measure/evaluate.h"
#include "base/random.h"
#include "runtime/evaluator.h"
#include "toy_faces.h"

namespace test_calibrate_errors {

using namespace fb;
using namespace fb::bake;

namespace {

TEST_CASE("weights are found again from errors that scatter") {
  // Mean squares that a sum of inputs tells, times squares of normal numbers: each alone is off by far.
  const std::vector<double> truth = {3e-4, 0, 5e-5, 2e-3, 1e-5};  // the last is the constant
  constexpr std::size_t poses = 3000, width = 4, squares_a_pose = 8;
  Random random(1);
  std::vector<float> inputs;
  std::vector<double> values;
  for (std::size_t n = 0; n < poses; ++n) {
    double mean = truth.back(), scatter = 0;
    for (std::size_t i = 0; i < width; ++i) {
      inputs.push_back(random.uniform() < 0.5f ? random.uniform() : 0);
      mean += truth[i] * inputs.back();
    }
    for (std::size_t k = 0; k < squares_a_pose; ++k) {
      double normal = -6;
      for (int u = 0; u < 12; ++u) normal += random.uniform();
      scatter += normal * normal / squares_a_pose;
    }
    values.push_back(mean * scatter);
  }
  const std::vector<double> found = fit_nonnegative(inputs, width, values, std::vector<double>(width + 1, 1e-4), 0.3);
  for (const std::size_t i : {0, 2, 3, 4}) CHECK(found[i] == doctest::Approx(truth[i]).epsilon(0.15));
  CHECK(found[1] < 1e-5);
}

TEST_CASE("what a control adds counts in units of its reach") {
  const RigSchema schema = face_of(linear_formula).schema();
  const std::vector<float> shares = reached(schema, std::vector<float>{0.5f, 2, -5, 0});
  CHECK(shares[0] == doctest::Approx(0.5f / schema.controls[0].reach()));
  CHECK(shares[1] == doctest::Approx(0.5));
  CHECK(shares[2] == 1);  // clamped to its range
  CHECK(shares[3] == 0);
}

// Two controls of the four are trained together in no pose, and one only up to half its range.
MemorySource limited_face() {
  MemorySource source = face_of(curved_formula);
  source.add_clip("dense", ClipKind::dense, Split::train, 1200, 0.6f, 1);
  source.add_clip("unseen", ClipKind::shot, Split::test, 200, 0.5f, 4);
  for (std::size_t frame = 0; frame < 1200; ++frame) {
    float* const pose = &source.edit_clip(0).controls[4 * frame];
    if (frame % 2 == 0)
      pose[0] = 0;
    else
      pose[3] = 0;
    pose[1] = std::min(pose[1], 1.5f);
  }
  return source;
}

TEST_CASE("a bake keeps what is expected of poses") {
  MemorySource source = limited_face();
  const WorkFolder folder;
  BakeOptions options = options_in(folder, "compact");
  const Baked baked = bake_face(source, options, silent_progress());
  const PackedModel model = archive::read_archive(baked.archive).model;
  const ExpectedErrors& expected = model.expected;
  REQUIRE(expected.regions.size() > 0);
  CHECK(expected.is_untrained(0, 3));
  CHECK(!expected.is_untrained(0, 1));
  CHECK(!expected.is_untrained(2, 3));
  CHECK(expected.trained_high[1] < 140);
  CHECK(expected.trained_high[2] > 240);

  const runtime::Evaluator face(model);
  runtime::Workspace workspace(face);
  const auto outside = [&](std::vector<float> pose) {
    std::uint32_t count = 0;
    face.expected_errors(pose.data(), nullptr, &count, workspace);
    return count;
  };
  CHECK(outside({0.5f, 1, -2, 0}) == 0);
  CHECK(outside({0, 2.5f, -2, 0}) == 1);
  CHECK(outside({0.5f, 1, -2, 0.5f}) == 2);

  // On poses that were held back, as many errors are above what is expected as below.
  const PoseSet training = training_poses(source, Use::backlot);
  const EvalReport report =
      evaluate_archive(baked.archive, source, Split::train, {}, silent_progress(), Detail::quality);
  std::size_t above = 0;
  for (const FrameErrors& frame : report.clips[0].frames) above += std::sqrt(frame.mse) > frame.expected;
  CHECK(above > training.size() / 5);
  CHECK(above < training.size() * 4 / 5);
}

TEST_CASE("too few poses held back calibrate nothing") {
  MemorySource source = curved_face();
  const WorkFolder folder;
  const Baked baked = bake_face(source, options_in(folder, "paper"), silent_progress());
  CHECK(archive::read_archive(baked.archive).model.expected.regions.empty());
}

}  // namespace

}  // namespace test_calibrate_errors
