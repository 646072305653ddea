// A rig of steps, whole numbers, an enumeration, an oscillation and smooth controls, baked whole.
#include <doctest/doctest.h>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/measure/evaluate.h"
#include "bake/pipeline/bake.h"
#include "toy_faces.h"

namespace test_jumping_face {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t most_bytes = 40'000;

// Largest error over D of the archive in poses of the rig, of which make(random) draws 500.
template <class Make>
double worst(const PackedModel& model, Source& rig, const Make& make) {
  Clip clip{"drawn", ClipKind::dense, Split::test, 30, 500, {}};
  Random random(11);
  for (std::size_t i = 0; i < clip.frames; ++i) {
    const std::vector<float> pose = make(random);
    clip.controls.insert(clip.controls.end(), pose.begin(), pose.end());
  }
  struct Drawn final : Source {
    Drawn(Source& of, Clip clip) : rig(of), drawn{std::move(clip)} {}
    const RigSchema& schema() const override { return rig.schema(); }
    const Mesh& rest() const override { return rig.rest(); }
    const std::vector<Clip>& clips() const override { return drawn; }
    void read(std::size_t, std::size_t first, std::size_t count, std::span<float> points) override {
      const std::size_t width = rig.schema().control_count();
      rig.evaluate(std::span(drawn[0].controls).subspan(first * width, count * width), count, points);
    }
    Source& rig;
    std::vector<Clip> drawn;
  } source(rig, std::move(clip));
  return evaluate_model(model, source, Split::test, {}, silent_progress()).total.max;
}

}  // namespace

TEST_CASE("controls that jump, have few values or oscillate are modelled, in a small archive") {
  const std::unique_ptr<Source> rig = open_source(FB_STEPS_RIG);
  const RigSchema& schema = rig->schema();
  for (const char* recipe : {"compact", "hero"}) {
    CAPTURE(recipe);
    const WorkFolder folder;
    BakeOptions options = options_in(folder, recipe);
    options.poses = 2000;
    options.epochs = 40;
    const Baked baked = bake_face(*rig, options, silent_progress());
    CHECK(baked.archive.size() <= most_bytes);
    const PackedModel model = archive::read_archive(baked.archive).model;
    for (std::size_t c = 0; c < schema.control_count(); ++c) {
      const Control& control = schema.controls[c];
      CAPTURE(control.name);
      const double alone = worst(model, *rig, [&](Random& random) {
        std::vector<float> pose = schema.rest_pose();
        pose[c] = random.uniform(control.minimum, control.maximum);
        return pose;
      });
      MESSAGE(recipe, " ", control.name, " ", alone);
      CHECK(alone < 2e-3);
    }
    const double among = worst(model, *rig, [&](Random& random) {
      std::vector<float> pose;
      for (const Control& control : schema.controls) {
        const bool on = random.uniform() < 0.35f;
        const float value = random.uniform(control.minimum, control.maximum);
        pose.push_back(on ? value : control.rest);
      }
      return pose;
    });
    MESSAGE(recipe, ", ", baked.archive.size(), " bytes, among others ", among);
    CHECK(among < 2e-2);
  }
}

}  // namespace test_jumping_face
