#include "bake/measure/locality.h"

#include <doctest/doctest.h>

#include <array>
#include <numeric>

#include "archive/writer.h"
#include "bake/compress/pack_model.h"
#include "bake_test_support.h"
#include "memory_source.h"

namespace test_locality {

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 5, controls = 3;
constexpr double rounding =
    1e-5;  // an archive rounds coefficients together, so each control stirs the others' last digit

bool belongs(std::size_t control, std::size_t vertex) {
  return vertex % side == control;  // a column of the grid each
}

MemorySource columns_rig(bool live = true) {
  return MemorySource(
      controls, side,
      [](const float* pose, std::span<float> points) {
        for (std::size_t v = 0; v < points.size() / 3; ++v)
          for (std::size_t c = 0; c < controls; ++c)
            if (belongs(c, v)) points[3 * v + 2] += pose[c];
      },
      live);
}

// What the rig does, and `leak` more at one vertex when a control moves.
std::vector<std::byte> archive_of(const MemorySource& rig, std::size_t control, std::size_t vertex, float leak) {
  FaceModel model;
  model.schema = rig.schema();
  model.rest = rig.rest();
  const auto rows = static_cast<std::uint32_t>(model.rest.points.size());
  std::vector<float> shapes(rows * controls);
  for (std::uint32_t c = 0; c < controls; ++c) {
    model.network.features.push_back({Feature::Kind::identity, c, 1, 0});
    model.network.direct.push_back(c);
    for (std::size_t v = 0; v < rows / 3; ++v)
      if (belongs(c, v)) shapes[c * rows + 3 * v + 2] = 1;
  }
  shapes[control * rows + 3 * vertex] += leak;
  model.basis = make_basis(rows, controls, shapes);
  return write_archive(pack_model(model, {}), {});
}

std::vector<Locality> locality_of(std::span<const std::span<const std::byte>> archives, Source& source) {
  RigEvaluator rig(source);
  return measure_locality(archives, rig, {}, silent_progress());
}

}  // namespace

TEST_CASE("a leak is found where it was planted, and only there") {
  MemorySource rig = columns_rig();
  const std::size_t vertex = 2 * side + 4;  // no control's
  const double diagonal = rig.rest().diagonal();
  const auto leaky = archive_of(rig, 1, vertex, static_cast<float>(0.25 * diagonal)), sound = archive_of(rig, 0, 0, 0);
  const std::array<std::span<const std::byte>, 2> archives = {leaky, sound};
  const std::vector<Locality> both = locality_of(archives, rig);
  REQUIRE(both.size() == 2);
  REQUIRE(both[0].leaks.size() == controls);
  CHECK(both[0].leaks[0].control == "control1");
  CHECK(both[0].leaks[0].vertex == vertex);
  // From rest to an end of the range, or from an end half as far or more to rest.
  CHECK(both[0].largest <= 0.2501);
  CHECK(both[0].largest >= 0.125);
  CHECK(both[0].leaks[1].leak < rounding);
  CHECK(both[0].leaks[0].alone_poses == 2);
  CHECK(both[0].leaks[0].alone_error == doctest::Approx(0.25).epsilon(1e-3));
  CHECK(both[0].leaks[0].alone_motion == doctest::Approx(1 / diagonal));
  CHECK(both[1].leaks[0].alone_error < rounding);
  CHECK(both[0].above == doctest::Approx(1.0 / 3));
  CHECK(both[1].largest < rounding);
  CHECK(both[1].above == 0);
}

TEST_CASE("motion where the rig moves the vertex too is no leak") {
  MemorySource rig = columns_rig();
  const auto archive = archive_of(rig, 1, side + 1, 1);  // its own vertex, sideways
  const std::array<std::span<const std::byte>, 1> archives = {archive};
  CHECK(locality_of(archives, rig).at(0).largest < rounding);
}

TEST_CASE("locality needs a live rig") {
  MemorySource rig = columns_rig(false);
  const auto archive = archive_of(rig, 0, 0, 0);
  const std::array<std::span<const std::byte>, 1> archives = {archive};
  const std::string why = fb::test::failure(Status::invalid_argument, [&] { locality_of(archives, rig); });
  CHECK(fb::test::contains(why, "no live rig"));
}

TEST_CASE("a budget of rig calls is kept, with fewer poses or none") {
  LocalityOptions options;
  CHECK(locality_calls(options, controls) == options.poses * (controls + 1));
  CHECK(locality_calls(options, 65) == options.poses * (65 + 2));  // the pose itself is asked for again
  CHECK(locality_within(UINT64_MAX, controls)->poses == options.poses);
  CHECK(locality_within(2 * (controls + 1) + 1, controls)->poses == 2);
  CHECK_FALSE(locality_within(controls, controls));
}

TEST_CASE("a recording's single poses show leaks and errors of the controls that have them") {
  MemorySource rig = columns_rig(false);
  rig.add_clip("singles", ClipKind::excitation, Split::train, 20, 0, 1);
  rig.add_clip("more", ClipKind::dense, Split::test, 3, 0, 1);
  for (std::size_t f = 1; f < 20; ++f) rig.edit_clip(0).controls[controls * f] = 0.05f * float(f);  // control 0, alone
  rig.edit_clip(1).controls = {0, 0.5f, 0, /* control 1 alone */ 0, 0.5f, 0.5f, 0, 0, 0};
  const std::size_t vertex = 2 * side + 4;  // no control's
  const auto leaky = archive_of(rig, 1, vertex, 0.25f), sound = archive_of(rig, 0, 0, 0);
  const std::array<std::span<const std::byte>, 2> archives = {leaky, sound};
  const std::vector<Locality> both = recorded_locality(archives, rig, {}, silent_progress());
  REQUIRE(both.size() == 2);
  const double diagonal = rig.rest().diagonal();
  CHECK(both[0].recorded_poses == 17);  // 16 of 19, and 1
  REQUIRE(both[0].leaks.size() == 2);   // control 2 is never alone
  CHECK(both[0].above == 0.5);
  const ControlLeak& worst = both[0].leaks[0];
  CHECK(worst.control == "control1");
  CHECK(worst.vertex == vertex);
  CHECK(worst.leak == doctest::Approx(0.125 / diagonal).epsilon(1e-3));
  CHECK(worst.alone_poses == 1);
  CHECK(worst.unseen_poses == 1);
  CHECK(worst.alone_error == doctest::Approx(0.125 / diagonal).epsilon(1e-3));
  CHECK(worst.alone_motion == doctest::Approx(0.5 / diagonal));
  CHECK(both[0].leaks[1].alone_poses == 16);
  CHECK(both[0].leaks[1].unseen_poses == 0);
  CHECK(both[0].leaks[1].alone_motion == doctest::Approx(0.95 / diagonal));
  CHECK(both[1].largest < rounding);

  rig.edit_clip(0).controls.assign(20 * controls, 0.5f);
  rig.edit_clip(1).controls.assign(3 * controls, 0.0f);
  CHECK(recorded_locality(archives, rig, {}, silent_progress()).empty());
}

}  // namespace test_locality
