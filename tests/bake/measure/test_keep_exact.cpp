// Poses that are kept exact: within rounding of the rig after a bake and after packing, and of no harm between.
#include "bake/measure/keep_exact.h"

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/repack.h"
#include "test_models.h"
#include "toy_faces.h"

namespace test_keep_exact {

using namespace fb;
using namespace fb::bake;

namespace {

// Controls that saturate together on the left half, which shapes of single controls and products cannot represent.
void folded_formula(const float* controls, std::span<float> points) {
  const auto c = shares(controls);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t x = i / 3 % 8;
    points[i] += x < 4 ? 0.5f * std::tanh(1.5f * (c[0] + 0.7f * c[1] - 0.6f * c[2])) * std::cos(0.3f * float(i))
                       : 0.4f * c[3] * std::sin(0.5f * float(i));
  }
}

// With a clip of keys, all controls at once, and another that is not trained on.
MemorySource folded_rig() {
  MemorySource rig = face_of(folded_formula, true);
  rig.add_clip("keys", ClipKind::shot, Split::train, 40, 1, 9);
  rig.add_clip("unseen", ClipKind::shot, Split::test, 300, 0.7f, 5);
  return rig;
}

BakeOptions exact_options(const WorkFolder& folder, const std::string& recipe, std::uint64_t seed) {
  BakeOptions options = options_in(folder, recipe);
  options.poses = 600;
  options.epochs = 6;
  options.seed = seed;
  options.exact = {"keys:3,9,17,30,39"};
  return options;
}

// The frames of the clip of keys that exact_options names, as the rig gives them.
std::vector<ExactFrame> true_frames(MemorySource& rig, const PackedModel& model) {
  std::vector<ExactFrame> frames;
  for (const ExactPose& pose : model.exact) {
    ExactFrame& frame =
        frames.emplace_back(ExactFrame{pose.name, pose.controls, std::vector<float>(rig.rest().points.size())});
    rig.evaluate(frame.controls, 1, frame.points);
  }
  return frames;
}

PackedModel model_in(const std::vector<std::byte>& archive) {
  return archive::read_archive(archive).model;
}

double max_error(const std::vector<std::byte>& archive, MemorySource& rig) {
  const PackedModel model = model_in(archive);
  return exact_errors(model, true_frames(rig, model)).max;
}

std::vector<std::byte> without_exact(const std::vector<std::byte>& archive) {
  PackedModel model = model_in(archive);
  model.exact.clear();
  return archive::write_archive(model, {});
}

nlohmann::json certificate_in(const std::vector<std::byte>& archive) {
  return nlohmann::json::parse(archive::read_archive(archive).text.certificate);
}

TEST_CASE("five frames come out within rounding, also after coarser packings, and no other pose gets worse") {
  for (const std::string recipe : {"linear", "compact"})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      INFO(recipe, ", seed ", seed);
      const WorkFolder folder;
      MemorySource rig = folded_rig();
      const Baked baked = bake_face(rig, exact_options(folder, recipe, seed), silent_progress());
      REQUIRE(model_in(baked.archive).exact.size() == 5);
      const std::vector<std::byte> before = without_exact(baked.archive);
      {
        const PackedModel plain = model_in(before);
        CHECK(exact_errors(plain, true_frames(rig, model_in(baked.archive))).max > 1e-4);
      }
      CHECK(max_error(baked.archive, rig) < 2e-6);
      const double with = unseen_mse(baked.archive, rig), without = unseen_mse(before, rig);
      MESSAGE(recipe, ", seed ", seed, ": exact max ", max_error(baked.archive, rig), ", unseen mse ", without, " to ",
              with);
      CHECK(with <= 1.05 * without);
      REQUIRE(baked.exact.has_value());
      const auto certified = certificate_in(baked.archive)["exact"];
      CHECK(certified["poses"] == 5);
      CHECK(certified["max"].get<double>() == doctest::Approx(max_error(baked.archive, rig)).epsilon(1e-4));

      std::vector<std::byte> packed = baked.archive;
      double bound = certified["max"];
      for (const double error : {0.02, 0.08}) {
        const RepackResult result = repack(packed, {.max_error = error}, silent_progress());
        CHECK(result.factor > 1);
        packed = result.archive;
        CHECK(max_error(packed, rig) < 3e-6);
        CHECK(certificate_in(packed)["exact"]["max"].get<double>() > bound);
        bound = certificate_in(packed)["exact"]["max"];
        CHECK(max_error(packed, rig) <= bound * (1 + 1e-5));  // of rounding
        verify_archive(packed);
      }
      CHECK(bound < 3e-6);
    }
}

TEST_CASE("what is not kept exact is baked as without, and another list bakes anew") {
  const WorkFolder folder, other;
  MemorySource rig = folded_rig();
  BakeOptions options = exact_options(folder, "linear", 1);
  const Baked first = bake_face(rig, options, silent_progress());
  options.exact = {"keys:5", "keys:6"};
  const Baked second = bake_face(rig, options, silent_progress());
  CHECK(model_in(second.archive).exact.size() == 2);
  CHECK(max_error(second.archive, rig) < 2e-6);
  CHECK(without_exact(first.archive) == without_exact(second.archive));
  options.exact.clear();
  const Baked plain = bake_face(rig, options, silent_progress());
  CHECK(!plain.exact);
  CHECK(!certificate_in(plain.archive).contains("exact"));
  CHECK(without_exact(first.archive) == without_exact(plain.archive));
  options.work = other.path;
  CHECK(bake_face(rig, options, silent_progress()).archive == plain.archive);
}

TEST_CASE("corrections count among the bytes of a bake") {
  const WorkFolder folder;
  MemorySource rig = folded_rig();
  BakeOptions options = exact_options(folder, "compact", 1);
  options.max_bytes = 290000;
  const Baked small = bake_face(rig, options, silent_progress());
  CHECK(small.archive.size() <= options.max_bytes);
  CHECK(model_in(small.archive).exact.size() == 5);
  CHECK(max_error(small.archive, rig) < 2e-6);
}

TEST_CASE("faces of extraordinary size are exact, too") {
  for (const float scale : {1e-25f, 1e25f}) {
    MemorySource rig = face_of(
        [scale](const float* controls, std::span<float> points) {
          std::vector<float> moved(points.size());
          folded_formula(controls, moved);
          for (std::size_t i = 0; i < points.size(); ++i) points[i] += scale * moved[i];
        },
        true);
    for (float& coordinate : rig.edit_rest().points) coordinate *= scale;
    rig.add_clip("keys", ClipKind::shot, Split::train, 40, 1, 9);
    const WorkFolder folder;
    const Baked baked = bake_face(rig, exact_options(folder, "linear", 1), silent_progress());
    CHECK(max_error(baked.archive, rig) < 2e-6);
    verify_archive(baked.archive);
  }
}

// Poses at such distances, in shares of the range of the first control, with points that have nothing in common.
std::vector<ExactFrame> frames_apart(const PackedModel& model, const std::vector<float>& distances) {
  Random random(7);
  std::vector<ExactFrame> frames;
  for (const float distance : distances) {
    ExactFrame& frame = frames.emplace_back(ExactFrame{std::to_string(distance), model.schema.rest_pose(), {}});
    const Control& first = model.schema.controls[0];
    frame.controls[0] = first.rest + distance * (first.maximum - first.minimum);
    for (const float coordinate : model.rest.points) frame.points.push_back(coordinate + random.uniform(-0.1f, 0.1f));
  }
  return frames;
}

TEST_CASE("poses close to each other, or to rest, do not disturb each other") {
  PackedModel model = character_model();
  const std::vector<ExactFrame> frames = frames_apart(model, {3e-6f, 0.5f, 0.5f + 2e-6f, 0.501f, 0.7f});
  keep_exact(model, frames);
  check(model);
  const Errors errors = exact_errors(model, frames);
  CHECK(errors.max < 2e-6);
  REQUIRE(errors.channels.size() == 4);
  for (const ChannelErrors& channel : errors.channels) CHECK(channel.max < 1e-4);
  // What a model says of itself is what it was given, within rounding; and again after that.
  const std::vector<ExactFrame> own = exact_frames(model);
  PackedModel again = model;
  keep_exact(again, own);
  CHECK(exact_errors(again, frames).max < 2e-6);
  for (std::size_t i = 0; i < frames.size(); ++i) CHECK(again.exact[i].falloff == model.exact[i].falloff);
}

TEST_CASE("equal poses are refused, and no poses are none") {
  PackedModel model = character_model();
  CHECK_THROWS_WITH_AS(keep_exact(model, frames_apart(model, {0.5f, 0.5f})), doctest::Contains("too close to rest"),
                       Error);
  CHECK_THROWS_WITH_AS(keep_exact(model, frames_apart(model, {0})), doctest::Contains("too close to rest"), Error);
  keep_exact(model, {});
  CHECK(model.exact.empty());
  CHECK(exact_frames(model).empty());
}

TEST_CASE("points far from the face are held, with steps that are coarser") {
  PackedModel model = character_model();
  std::vector<ExactFrame> frames = frames_apart(model, {0.5f});
  frames[0].points[7] = 1e4f * static_cast<float>(model.rest.diagonal());
  keep_exact(model, frames);
  check(model);
  CHECK(exact_errors(model, frames).max < 1e-3);
}

}  // namespace

}  // namespace test_keep_exact
