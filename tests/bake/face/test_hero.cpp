#include <doctest/doctest.h>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/pipeline/bake.h"
#include "toy_faces.h"

namespace test_hero {

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;

namespace {

// Controls that saturate together on the left half, which shapes of single controls and products cannot represent. The
// last control alone moves the right half.
void saturating_formula(const float* controls, std::span<float> points) {
  const auto c = shares(controls);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t x = i / 3 % 8;
    points[i] += x < 4 ? 0.5f * std::tanh(1.5f * (c[0] + 0.7f * c[1] - 0.6f * c[2])) * std::cos(0.3f * float(i))
                       : 0.4f * c[3] * std::sin(0.5f * float(i));
  }
}

MemorySource saturating_rig() {
  MemorySource rig = face_of(saturating_formula, true);
  rig.add_clip("unseen", ClipKind::shot, Split::test, 200, 0.7f, 5);
  return rig;
}

BakeOptions quick(const WorkFolder& folder, const std::string& recipe) {
  BakeOptions options = options_in(folder, recipe);
  options.poses = 1000;
  options.epochs = 6;
  return options;
}

double mse_of(const std::string& recipe, MemorySource rig) {
  const WorkFolder folder;
  BakeOptions options = quick(folder, recipe);
  options.epochs = 50;
  return unseen_mse(bake_face(rig, options, silent_progress()).archive, rig);
}

}  // namespace

TEST_CASE("hero and compact learn the residual of single controls and correctives") {
  const double linear = mse_of("linear", saturating_rig());
  const double compact = mse_of("compact", saturating_rig()), hero = mse_of("hero", saturating_rig());
  MESSAGE("linear ", linear, ", compact ", compact, ", hero ", hero);
  // Of linear's error, seeds 1 to 8: 0.04 to 0.22, and 0.04 to 0.11.
  CHECK(compact < 0.35 * linear);
  CHECK(hero < 0.2 * linear);
}

TEST_CASE("single controls are exact through blendshapes alone, and move no vertex of another region") {
  const WorkFolder folder;
  MemorySource rig = saturating_rig();
  const Baked baked = bake_face(rig, quick(folder, "hero"), silent_progress());
  for (std::size_t control = 0; control < 4; ++control) {
    MemorySource single = face_of(saturating_formula, true);
    single.add_clip("unseen", ClipKind::shot, Split::test, 21, 0, 1);
    for (std::size_t frame = 0; frame < 21; ++frame) {
      const Control& c = single.schema().controls[control];
      single.edit_clip(0).controls[frame * 4 + control] = c.minimum + (c.maximum - c.minimum) * float(frame) / 20;
    }
    CHECK(unseen_mse(baked.archive, single) < 1e-8);  // error of a curve between its knots
  }
  // The last control is an input of no network: it moves the right half, which has no residual.
  const PackedModel model = read_archive(baked.archive).model;
  for (const PackedRegion& region : model.regions)
    for (const std::uint32_t f : region.features)
      if (!model.features[f].of_features()) CHECK(model.features[f].control != 3);
}

TEST_CASE(
    "within a rig budget, poses are chosen by variance; a budget too small for analysis is spent on poses alone") {
  for (const std::uint64_t budget : {200u, 900u}) {
    const WorkFolder folder;
    MemorySource rig = saturating_rig();
    BakeOptions options = quick(folder, "hero");
    options.rig_budget = budget;
    options.epochs = 80;
    const Baked baked = bake_face(rig, options, silent_progress());
    CHECK(baked.asked <= budget);
    CHECK(baked.asked > 0.9 * double(budget));
    CHECK((baked.stats.rig_calls > 0) == (budget == 900));
    const auto recorded = open_source((options.work / "poses").string());
    std::size_t chosen = 0;
    for (const Clip& clip : recorded->clips()) chosen += clip.name.starts_with("chosen_") ? clip.frames : 0;
    CHECK(chosen > budget / 8);
    // 200 poses are too few to beat blendshapes, but must not be much worse. 900: 0.09 to 0.32 of their error, seeds 1
    // to 5.
    CHECK(unseen_mse(baked.archive, rig) < (budget == 900 ? 0.5 : 4) * mse_of("linear", saturating_rig()));
  }
}

TEST_CASE("a rig of plain morph targets needs no network") {
  for (const char* recipe : {"compact", "hero"}) {
    const WorkFolder folder;
    MemorySource rig = face_of(linear_formula, true);
    rig.add_clip("unseen", ClipKind::shot, Split::test, 100, 0.6f, 2);
    const Baked baked = bake_face(rig, quick(folder, recipe), silent_progress());
    CHECK(baked.parameters == 0);
    CHECK(unseen_mse(baked.archive, rig) < 1e-10);
  }
}

TEST_CASE("without a live rig, the blendshapes are fitted to recorded poses") {
  MemorySource source = curved_face();
  const WorkFolder linear_folder, folder;
  BakeOptions options = options_in(folder, "hero");
  const double linear =
      unseen_mse(bake_face(source, options_in(linear_folder, "linear"), silent_progress()).archive, source);
  const double hero = unseen_mse(bake_face(source, options, silent_progress()).archive, source);
  MESSAGE("linear ", linear, ", hero ", hero);
  CHECK(hero < 0.2 * linear);
}

TEST_CASE("the same seed gives the same archive whatever the number of threads") {
  std::vector<std::byte> archives[2];
  for (const int threads : {1, 2}) {
    const WorkFolder folder;
    MemorySource rig = saturating_rig();
    BakeOptions options = quick(folder, "compact");
    options.epochs = 3;
    options.parallel.threads = threads;
    archives[threads - 1] = bake_face(rig, options, silent_progress()).archive;
  }
  CHECK(archives[0] == archives[1]);
}

}  // namespace test_hero
