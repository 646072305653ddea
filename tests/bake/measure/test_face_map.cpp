#include "bake/measure/face_map.h"

#include <doctest/doctest.h>

#include <array>

#include "bake/compress/pack_model.h"
#include "bake/measure/face_parts.h"
#include "memory_source.h"

namespace test_face_map {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 9;

// A sheet whose four corners are moved by a control each, and all of it by a fifth.
PackedModel corners_face(const std::string& up_axis = "y") {
  MemorySource source(5, side, [](const float*, std::span<float>) {});
  FaceModel model;
  model.schema = source.schema();
  model.schema.up_axis = up_axis;
  const std::array<const char*, 5> names = {"smileR", "smileL", "browR", "browL", "head"};
  const std::array<const char*, 5> groups = {"mouth", "mouth", "brow", "brow", "neck"};
  model.rest = source.rest();
  if (up_axis == "z")
    for (std::size_t v = 0; v < side * side; ++v) std::swap(model.rest.points[3 * v + 1], model.rest.points[3 * v + 2]);
  const std::size_t rows = model.rest.points.size();
  std::vector<float> shapes(5 * rows);
  for (std::uint32_t c = 0; c < 5; ++c) {
    model.schema.controls[c].name = names[c];
    model.schema.controls[c].group = groups[c];
    model.network.features.push_back({Feature::Kind::identity, c, 1, 0});
    model.network.direct.push_back(c);
    for (std::size_t v = 0; v < side * side; ++v) {
      const bool left = v % side > side / 2, upper = v / side > side / 2;
      const bool middle = v % side == side / 2 || v / side == side / 2;
      if (c == 4 || (!middle && c == std::size_t(left) + 2 * std::size_t(upper))) shapes[c * rows + 3 * v] = 1;
    }
  }
  model.basis = make_basis(static_cast<std::uint32_t>(rows), 5, shapes);
  return pack_model(model, {});
}

const std::uint32_t lower_right = 0, lower_left = side - 1, centre = side * side / 2, upper_left = side * side - 1;

}  // namespace

TEST_CASE("places are those of the face: its own left, and up as the rig says") {
  for (const char* up_axis : {"y", "z"}) {
    const FaceMap map(corners_face(up_axis), {});
    const auto place = [&](std::uint32_t vertex) { return map.place_in(map.moving_part(), std::array{vertex}); };
    CHECK(place(lower_right).starts_with("lower right"));
    CHECK(place(lower_left).starts_with("lower left"));
    CHECK(place(upper_left).starts_with("upper left"));
    CHECK(place(centre).starts_with("middle"));
    CHECK(map.name_of(upper_left).starts_with("brow, upper left"));
  }
}

TEST_CASE("a control that moves everything counts less than one that moves the place") {
  const FaceMap map(corners_face(), {});
  CHECK(map.movers(std::array{lower_left}, 2) == std::vector<std::uint32_t>{1, 4});
  CHECK(map.movers(std::array{upper_left}, 1) == std::vector<std::uint32_t>{3});
  CHECK(map.movers(std::array{centre}, 5) == std::vector<std::uint32_t>{4});
  CHECK(map.moved_by(2).size() == (side / 2) * (side / 2));
  CHECK(map.moved_by(4).size() == side * side);
}

TEST_CASE("regions are named by what moves them and where they lie, each unlike the others") {
  const PackedModel model = corners_face();
  const FaceMap map(model, {});
  FaceParts parts{{"one", "two", "three", "four", "five"}, std::vector<std::uint32_t>(side * side, 5)};
  parts.labels[lower_left] = 0;
  parts.labels[lower_left - 1] = 1;
  parts.labels[lower_right] = 2;
  parts.labels[upper_left] = 3;
  describe(parts, map, model.schema);
  // Without the place at the front or the back, which this sheet has at random.
  const auto begins = [&](std::size_t part, const char* title) { return parts.titles.at(part).starts_with(title); };
  CHECK(begins(0, "mouth, left"));  // among the mouth's, which lie at one height
  CHECK(begins(1, "mouth, left"));
  CHECK(parts.titles[0] != parts.titles[1]);
  CHECK(begins(2, "mouth, right"));
  CHECK(begins(3, "brow, upper left"));  // the only one of the brow
  CHECK(parts.titles.at(4).empty());
  CHECK(parts.movers.at(2) == std::vector<std::string>{"smileR", "head"});
  CHECK(parts.movers.at(4).empty());
}

}  // namespace test_face_map
