// Expected errors of poses: the formula of EVALUATION.md, what counts as outside of what was trained, single poses and
// batches.
#include <doctest/doctest.h>

#include <cmath>

#include "runtime/evaluator.h"
#include "test_models.h"

namespace test_error_prediction {

using namespace fb;
using namespace fb::runtime;

namespace {

struct Answer {
  std::vector<float> errors;
  std::uint32_t outside = 0;
};

Answer expected_of(const Evaluator& face, const std::vector<float>& pose) {
  Workspace workspace(face);
  Answer answer{std::vector<float>(face.error_count())};
  face.expected_errors(pose.data(), answer.errors.data(), &answer.outside, workspace);
  return answer;
}

TEST_CASE("errors of controls add up in squares") {
  const PackedModel model = character_model();
  const Evaluator face(model);
  REQUIRE(face.error_count() == 3);
  std::vector<float> pose = model.schema.rest_pose();
  const Answer rest = expected_of(face, pose);
  CHECK(rest.errors[1] == model.expected.unit * std::sqrt(model.expected.regions[0].constant));
  CHECK(rest.errors[2] == 0);
  CHECK(rest.errors[0] == doctest::Approx(std::sqrt(rest.errors[1] * rest.errors[1] * 18 / 30)));
  CHECK(rest.outside == 0);
  pose[0] = 0.25f;
  pose[3] = 1;  // half its reach
  const Answer moved = expected_of(face, pose);
  const auto weight = [&](std::size_t c, std::size_t r) { return decoded_weight(model.expected.weights[2 * c + r]); };
  const double squares = 0.125 * weight(0, 1) + std::pow(0.5, 1.5) * weight(3, 1);
  CHECK(moved.errors[2] == doctest::Approx(model.expected.unit * std::sqrt(squares)));
  CHECK(moved.errors[1] > rest.errors[1]);
}

TEST_CASE("values and pairs that were never trained are counted once a control") {
  const PackedModel model = character_model();
  const Evaluator face(model);
  const auto outside = [&](std::vector<float> pose) { return expected_of(face, pose).outside; };
  // Trained from 10 / 255 to 200 / 255 of their ranges; 0 with 1 and 1 with 3 never together.
  CHECK(outside({0.78f, 0, 0.25f, 0, 0}) == 0);
  CHECK(outside({0.79f, 0, 0.25f, 0, 0}) == 1);
  CHECK(outside({0, -0.95f, 0.25f, 0, 0}) == 1);
  CHECK(outside({0.3f, 0.3f, 0.25f, 0, 0}) == 2);
  CHECK(outside({0.24f, 0.3f, 0.25f, 0, 0}) == 0);
  CHECK(outside({0.3f, 0.3f, 0.25f, 0.6f, 0}) == 3);
  CHECK(outside({0.3f, 0, 0.25f, 0.6f, 0}) == 0);
  CHECK(outside({0.9f, 0.3f, 0.25f, 0, 0}) == 2);
  CHECK(outside({9, 0, 0.25f, 0, 0}) == 1);  // clamped to 1
}

TEST_CASE("regions are told by vertex in the source's order") {
  const PackedModel model = character_model();
  const Evaluator face(model);
  REQUIRE(face.error_regions().size() == 30);
  for (std::size_t i = 0; i < 30; ++i) CHECK(face.error_regions()[model.order[i]] == (i >= 9 && i < 21 ? 1 : 0));
}

TEST_CASE("a batch has the bits of single poses, at any stride and on any thread") {
  const PackedModel model = character_model();
  const Evaluator face(model);
  constexpr std::size_t poses = 37, stride = 5;
  Random random(4);
  std::vector<float> controls, errors(poses * stride, -1);
  for (std::size_t p = 0; p < poses; ++p)
    for (const float value : random_pose(model.schema, random)) controls.push_back(value);
  std::vector<std::uint32_t> outside(poses);
  std::vector<Workspace> workspaces;
  for (int worker = 0; worker < 3; ++worker) workspaces.emplace_back(face);
  Batch batch;
  batch.poses = poses;
  batch.controls = controls;
  batch.errors = {errors.data(), errors.size(), stride, outside.data()};
  face.evaluate_batch(batch, workspaces);
  for (std::size_t p = 0; p < poses; ++p) {
    const std::size_t width = face.control_count();
    const Answer one = expected_of(face, {controls.begin() + p * width, controls.begin() + (p + 1) * width});
    for (std::size_t i = 0; i < 3; ++i) CHECK(errors[p * stride + i] == one.errors[i]);
    CHECK(errors[p * stride + 3] == -1);
    CHECK(outside[p] == one.outside);
  }
  batch.errors.size = (poses - 1) * stride + 2;
  CHECK_THROWS_WITH_AS(face.evaluate_batch(batch, workspaces), doctest::Contains("expected errors"), Error);
  batch.errors = {errors.data(), errors.size(), 2, nullptr};
  CHECK_THROWS_WITH_AS(face.evaluate_batch(batch, workspaces), doctest::Contains("overlap"), Error);
}

TEST_CASE("faces without expected errors, and controls that are no numbers, are refused") {
  const Evaluator face(tiny_packed_model()), character(character_model());
  Workspace workspace(face), other(character);
  std::vector<float> pose = face.schema().rest_pose(), errors(3);
  std::uint32_t outside = 0;
  CHECK(face.error_count() == 0);
  CHECK(face.error_regions().empty());
  CHECK_THROWS_WITH_AS(face.expected_errors(pose.data(), errors.data(), &outside, workspace),
                       doctest::Contains("no expected errors"), Error);
  Batch batch;
  batch.poses = 1;
  batch.controls = pose;
  batch.errors.outside = &outside;
  CHECK_THROWS_WITH_AS(face.evaluate_batch(batch, {&workspace, 1}), doctest::Contains("no expected errors"), Error);
  pose[1] = NAN;
  CHECK_THROWS_WITH_AS(character.expected_errors(pose.data(), errors.data(), &outside, other),
                       doctest::Contains("\"mouth_side\" is not a number"), Error);
}

}  // namespace

}  // namespace test_error_prediction
