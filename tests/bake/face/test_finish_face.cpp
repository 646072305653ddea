// The bounds of recipes and users on what a pose takes: what is part of them, and what becomes of those that cannot be
// met.
#include "bake/face/finish_face.h"

#include <doctest/doctest.h>

#include <cmath>

#include "bake/compress/fit_target.h"
#include "bake/face/face_recipe.h"
#include "bake/measure/bytes_read.h"
#include "bake/sampling/sampling.h"
#include "toy_faces.h"
#include "watched_progress.h"

namespace test_finish_face {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 40, moved = 12 * side;  // vertices: all, and those that the controls move
constexpr double threshold = 1e-6;

// One control each moves the same vertices.
MemorySource face_with_a_still_part() {
  MemorySource source(3, side, [](const float* controls, std::span<float> points) {
    for (std::size_t i = 0; i < 3 * moved; ++i)
      for (std::size_t c = 0; c < 3; ++c) points[i] += controls[c] * std::sin(float((c + 1) * i));
  });
  source.add_clip("dense", ClipKind::dense, Split::train, 60, 0.6f, 1);
  return source;
}

FaceModel shapes_of(const MemorySource& source) {
  FaceModel model;
  model.schema = source.schema();
  model.rest = source.rest();
  std::vector<float> shapes;
  for (std::uint32_t c = 0; c < 3; ++c) {
    model.network.features.push_back({Feature::Kind::identity, c});
    model.network.direct.push_back(c);
    for (std::size_t i = 0; i < model.rest.points.size(); ++i)
      shapes.push_back(i < 3 * moved ? std::sin(float((c + 1) * i)) : 0.0f);
  }
  model.basis = make_basis(static_cast<std::uint32_t>(model.rest.points.size()), 3, shapes);
  return model;
}

double bytes_at_rest(const PackedModel& packed) {
  return double(BytesReadCounter(packed).of_pose(packed.schema.rest_pose()));
}

// Mean over bounded_shots.
double bytes_read(const PackedModel& packed, std::uint64_t seed) {
  const Clip shots = bounded_shots(packed.schema, seed);
  const BytesReadCounter counter(packed);
  double sum = 0;
  for (std::size_t frame = 0; frame < shots.frames; ++frame)
    sum += double(counter.of_pose(frames_of(shots, frame, 1, packed.schema.control_count()))) / double(shots.frames);
  return sum;
}

struct Finisher {
  MemorySource source = face_with_a_still_part();
  FaceModel model = shapes_of(source);
  BakeOptions options;
  test::Notes notes;

  RecipeResult finish(double max_bytes_read) {
    BlockwisePcaOptions blockwise;
    blockwise.threshold = threshold;
    return finish_face(model, {}, blockwise, Precision{threshold, 8}.pack(),
                       {training_poses(source, Use::variant), options.seed}, options, notes, max_bytes_read);
  }
};

}  // namespace

TEST_CASE("what the rest pose reads is no part of the bytes that a recipe's poses may read") {
  Finisher face;
  const RecipeResult free = face.finish(0);
  const double constant = bytes_at_rest(*free.packed);
  const double all = bytes_read(*free.packed, face.options.seed);
  CHECK(constant > 12.0 * side * side);
  CHECK(all > constant);

  const RecipeResult bounded = face.finish(1.01 * (all - constant));
  CHECK(bounded.packing.step == free.packing.step);
  CHECK(bounded.warnings.empty());
  CHECK(face.notes.all.find("precision is divided") == std::string::npos);
}

TEST_CASE("a lowered precision is told, and bytes that cannot be met lower none") {
  Finisher face;
  const RecipeResult free = face.finish(0);
  const double constant = bytes_at_rest(*free.packed);
  const double variable = bytes_read(*free.packed, face.options.seed) - constant;

  const RecipeResult lowered = face.finish(0.8 * variable);
  CHECK(lowered.packing.step > free.packing.step);
  CHECK(bytes_read(*lowered.packed, face.options.seed) - constant <= 0.8 * variable);
  REQUIRE(lowered.stats.notes.size() == 1);
  CHECK(lowered.stats.notes[0].find("the recipe's precision is divided by ") == 0);
  CHECK(face.notes.all.find(lowered.stats.notes[0]) != std::string::npos);
  CHECK(lowered.warnings.empty());

  const RecipeResult kept = face.finish(1);
  CHECK(kept.packing.step == free.packing.step);
  REQUIRE(kept.warnings.size() == 1);
  CHECK(kept.warnings[0].find("poses of this face cannot keep to the ") == 0);
}

TEST_CASE("what the user asked for is refused where it cannot be met, or forced with a warning") {
  Finisher face;
  struct Asked {
    std::uint64_t bytes;
    double error;
    const char* text;
  };
  for (const Asked& asked :
       {Asked{10, 0, "asked for 10 bytes, the smallest reached is "}, Asked{0, 1e-12, "asked for an error of 1e-12"}}) {
    face.options.max_bytes = asked.bytes;
    face.options.max_error = asked.error;
    face.options.force = false;
    CHECK_THROWS_WITH(face.finish(1), doctest::Contains(asked.text));
    face.options.force = true;
    const RecipeResult forced = face.finish(0);
    REQUIRE(forced.warnings.size() == 1);
    CHECK(forced.warnings[0].find(asked.text) == 0);
  }
}

TEST_CASE("the bytes of recipes grow with the vertices of large faces") {
  const FaceRecipe recipe = compact_recipe();
  CHECK(recipe.bytes_for(1000, 64) == 1000);
  CHECK(recipe.bytes_for(1000, recipe.full_size_vertices) == 1000);
  CHECK(recipe.bytes_for(1000, 10 * recipe.full_size_vertices) == 10'000);
}

}  // namespace test_finish_face
