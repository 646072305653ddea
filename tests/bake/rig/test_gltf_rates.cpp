// At which rates animations of glTF files are read: keys stay what they are.
#include <algorithm>
#include <cmath>

#include "bake/rig/gltf/gltf_rig.h"
#include "bake_test_support.h"
#include "gltf_avatar.h"

namespace test_gltf_rates {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

// A rig that has one animation: these keys of jawOpen, which the teeth have alone.
OpenedSource with_keys(const std::vector<float>& times, const std::vector<float>& values) {
  GltfAvatar avatar;
  avatar.json["animations"] = {
      {{"name", "talk"},
       {"samplers",
        {{{"input", avatar.more().accessor(times, "SCALAR", 1)},
          {"output", avatar.more().accessor(values, "SCALAR", 1)}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", GltfAvatar::teeth_mesh}, {"path", "weights"}}}}}}}};
  const std::string bytes = avatar.glb();
  return open_gltf_rig(std::as_bytes(std::span(bytes)), "avatar");
}

float jaw_at(const Source& rig, std::size_t frame) {
  return rig.clips().at(0).controls.at(frame * rig.schema().control_count() + rig.schema().find("jawOpen").value());
}

bool has_rate_note(const Source& rig) {
  return std::ranges::any_of(rig.notes(), [](const std::string& note) { return contains(note, "frame rate"); });
}

}  // namespace

TEST_CASE("a blink at 24 frames a second closes the lids") {
  std::vector<float> times, values;
  for (int key = 0; key <= 24; ++key) {
    times.push_back(static_cast<float>(key / 24.0));
    values.push_back(key == 7 ? 1.0f : key == 6 || key == 8 ? 0.4f : 0.0f);
  }
  const auto rig = with_keys(times, values);
  CHECK(rig->clips()[0].fps == 24);
  REQUIRE(rig->clips()[0].frames == 25);
  for (std::size_t key = 0; key < values.size(); ++key) CHECK(jaw_at(*rig, key) == values[key]);
  CHECK_FALSE(has_rate_note(*rig));
}

TEST_CASE("keys on frames of a rate in use are frames of that rate") {
  for (const double rate : {24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 72.0, 90.0, 100.0, 120.0, 144.0, 240.0, 24000 / 1001.0,
                            30000 / 1001.0, 60000 / 1001.0})
    for (const int first : {0, 1, 3600}) {
      CAPTURE(rate);
      CAPTURE(first);
      const std::vector<int> keys = {0, 1, 2, 3, 5, 8, 13, 14, 21, 34, 55, 89, 144, 233, 377};
      std::vector<float> times, values;
      for (const int key : keys) {
        times.push_back(static_cast<float>((first + key) / rate));
        values.push_back(static_cast<float>(key % 7) / 6);
      }
      const auto rig = with_keys(times, values);
      CHECK(rig->clips()[0].fps == doctest::Approx(rate).epsilon(1e-12));
      REQUIRE(rig->clips()[0].frames == 378);
      for (std::size_t k = 0; k < keys.size(); ++k) CHECK(jaw_at(*rig, std::size_t(keys[k])) == values[k]);
      CHECK_FALSE(has_rate_note(*rig));
    }
}

TEST_CASE("times that are written with three decimals are frames") {
  std::vector<float> times, values;
  for (int key = 0; key < 60; ++key) {
    times.push_back(static_cast<float>(std::round(key / 24.0 * 1000) / 1000));
    values.push_back(static_cast<float>(key % 2));
  }
  const auto rig = with_keys(times, values);
  CHECK(rig->clips()[0].fps == 24);
  for (std::size_t key = 0; key < values.size(); ++key) CHECK(jaw_at(*rig, key) == values[key]);
}

TEST_CASE("keys that say no rate are read at 30 frames a second") {
  CHECK((*with_keys({0, 1, 2}, {0, 1, 0})).clips()[0].fps == 30);
  CHECK((*with_keys({5}, {1})).clips()[0].fps == 30);
}

TEST_CASE("keys on no common rate are moved to the nearest frame, with a note") {
  const std::vector<float> times = {0, 0.0137f, 0.0519f, 0.0913f, 0.1511f, 0.2003f, 0.3301f, 0.5777f};
  const std::vector<float> values = {0, 0.125f, 1, 0.25f, 0.875f, 0, 0.75f, 0};
  const auto rig = with_keys(times, values);
  CHECK(rig->clips()[0].fps == 120);
  for (std::size_t k = 0; k < times.size(); ++k)
    CHECK(jaw_at(*rig, std::size_t(std::lround(double(times[k]) * 120))) == values[k]);
  CHECK(has_rate_note(*rig));
  // A long one, of few keys, at the rate that all files were read at before.
  const auto longer = with_keys({0, 0.0137f, 40000.0519f}, {0, 1, 0});
  CHECK(longer->clips()[0].fps == 30);
  CHECK(has_rate_note(*longer));
}

}  // namespace test_gltf_rates
