#include "bake/measure/held_back_errors.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "bake/face/face_recipe.h"
#include "bake/sampling/validation_split.h"
#include "base/file.h"
#include "toy_faces.h"

namespace test_held_back_errors {

using namespace fb;
using namespace fb::bake;

namespace {

// Controls that saturate together, which shapes of single controls and products do not represent.
void saturating_formula(const float* controls, std::span<float> points) {
  const auto c = shares(controls);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] += 0.5f * std::tanh(1.5f * (c[0] + 0.7f * c[1] - 0.6f * c[2] + 0.5f * c[3])) * std::cos(0.3f * float(i));
}

// Twenty controls that act in all combinations: far more than a few hundred poses teach.
constexpr std::size_t entangled_controls = 20;
void entangled_formula(const float* controls, std::span<float> points) {
  for (std::size_t k = 0; k < 12; ++k) {
    double sum = 0;
    for (std::size_t c = 0; c < entangled_controls; ++c)
      sum += controls[c] * std::sin(double(7 * k * k + 13 * c + k * c));
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] += float(0.2 * std::sin(0.4 * sum) * std::cos(0.3 * double(k * i)));
  }
}

// A recorded face whose points in poses held back are moved by `shift`.
class ShiftedRecording final : public MemorySource {
 public:
  ShiftedRecording(MemorySource source, float shift) : MemorySource(std::move(source)), shift_(shift) {
    const PoseSet poses = training_poses(*this, Use::backlot);
    const PoseSet held = TrainingPoses(poses, 1).held_back();
    for (const PoseSet::Range& range : held.ranges()) held_ranges_.push_back(range);
  }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override {
    MemorySource::read(clip, first, count, points);
    const std::size_t size = rest().points.size();
    for (const PoseSet::Range& range : held_ranges_)
      for (std::size_t i = 0; i < count; ++i)
        if (range.clip == clip && first + i >= range.frame && first + i < range.frame + range.count)
          for (std::size_t k = 0; k < size; ++k) points[i * size + k] += shift_ * std::cos(float(k));
  }
  std::size_t held_frames() const {
    std::size_t frames = 0;
    for (const PoseSet::Range& range : held_ranges_) frames += range.count;
    return frames;
  }

 private:
  float shift_;
  std::vector<PoseSet::Range> held_ranges_;
};

ShiftedRecording recording(float shift) {
  MemorySource face = face_of(saturating_formula);
  face.add_clip("dense", ClipKind::dense, Split::train, 400, 0.6f, 1);
  face.add_clip("shot", ClipKind::shot, Split::train, 200, 0.5f, 2);
  face.add_clip("unseen", ClipKind::dense, Split::test, 200, 0.6f, 4);
  return ShiftedRecording(std::move(face), shift);
}

Basis basis_of(Source& source) {
  const WorkFolder folder;
  BakeOptions options = options_in(folder, "hero");
  options.epochs = 2;
  make_folder(options.work);
  return train_face(hero_recipe(), {training_poses(source, Use::backlot), options.seed}, nullptr, options,
                    silent_progress())
      .model.basis;
}

}  // namespace

TEST_CASE("no blendshape is fitted to a pose that is held back") {
  ShiftedRecording as_recorded = recording(0), shifted = recording(0.4f);
  REQUIRE(shifted.held_frames() >= 15);
  const Basis one = basis_of(as_recorded), other = basis_of(shifted);
  CHECK(one.columns > 8);  // more than shapes of single controls
  REQUIRE(one.columns == other.columns);
  REQUIRE(one.row_blocks.size() == other.row_blocks.size());
  for (std::size_t b = 0; b < one.row_blocks.size(); ++b) CHECK(one.row_blocks[b].values == other.row_blocks[b].values);
}

TEST_CASE("errors on poses held back are those of unseen poses of the same kind, and in the certificate") {
  const WorkFolder folder;
  ShiftedRecording source = recording(0);
  BakeOptions options = options_in(folder, "hero");
  options.epochs = 10;
  const Baked baked = bake_face(source, options, silent_progress());
  const HeldBackErrors& errors = baked.held_back;
  CHECK(errors.total.frames == source.held_frames());
  REQUIRE(errors.kinds.size() == 2);
  CHECK(errors.kinds[0].kind == "shot");
  CHECK(errors.kinds[1].kind == "dense");
  CHECK(errors.kinds[0].errors.frames + errors.kinds[1].errors.frames == errors.total.frames);
  const double unseen = std::sqrt(unseen_mse(baked.archive, source));
  MESSAGE("held back ", errors.kinds[1].errors.rms, ", unseen ", unseen, ", trained on ", baked.dependency.rms);
  CHECK(errors.kinds[1].errors.rms > 0.3 * unseen);
  CHECK(errors.kinds[1].errors.rms < 3 * unseen);

  const auto certificate = nlohmann::json::parse(archive::read_archive(baked.archive).text.certificate);
  CHECK(certificate["held_back"]["frames"] == errors.total.frames);
  CHECK(certificate["held_back"]["kinds"].size() == 2);
  CHECK(certificate["held_back"]["kinds"][0]["kind"] == "shot");
  CHECK(text_of(errors).find("shot") != std::string::npos);
  CHECK(text_of(errors).find("give or take") != std::string::npos);

  options.recipe = "linear";  // fitted to all poses
  CHECK(bake_face(source, options, silent_progress()).held_back.total.frames == 0);
}

TEST_CASE("a face that has learnt its poses by heart is told to be as bad as it is on others") {
  MemorySource source(entangled_controls, 5, entangled_formula);
  source.add_clip("dense", ClipKind::dense, Split::train, 600, 1, 1);
  source.add_clip("unseen", ClipKind::dense, Split::test, 400, 1, 2);
  double trained = 0, told = 0, unseen = 0;  // squares: few poses are held back, of which the hardest weigh most
  for (const std::uint64_t seed : {1, 2}) {
    const WorkFolder folder;
    BakeOptions options = options_in(folder, "hero");
    options.epochs = 120;
    options.seed = seed;
    const Baked baked = bake_face(source, options, silent_progress());
    trained += baked.dependency.mse;
    told += baked.held_back.total.mse;
    unseen += baked.independent->total.mse;
  }
  MESSAGE("rms trained on ", std::sqrt(trained / 2), ", told ", std::sqrt(told / 2), ", unseen ",
          std::sqrt(unseen / 2));
  CHECK(std::sqrt(trained / unseen) < 0.5);
  CHECK(std::sqrt(told / unseen) > 0.8);
  CHECK(std::sqrt(told / unseen) < 1.2);
}

}  // namespace test_held_back_errors
