// Materials in pictures, and the part of a mesh that moves.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "render/appearance.h"
#include "render/moving_part.h"
#include "render/png_file.h"
#include "render/rasterizer.h"
#include "render/shading.h"
#include "render/texture.h"
#include "temporary_folder.h"

using namespace fb;
using namespace fb::tool;

namespace {

constexpr Rgb red = {200, 0, 0}, green = {0, 200, 0}, blue = {0, 0, 200}, white = {255, 255, 255};

// Red and green above, blue and white below, each `edge` x `edge` pixels.
Image four_colours(int edge) {
  Image image(2 * edge, 2 * edge);
  for (int y = 0; y < 2 * edge; ++y)
    for (int x = 0; x < 2 * edge; ++x) image.at(x, y) = y < edge ? x < edge ? red : green : x < edge ? blue : white;
  return image;
}

std::vector<std::byte> png_of(const Image& image) {
  const test::Folder folder;
  write_png(folder / "picture.png", image);
  return read_file(folder / "picture.png");
}

// The channel that stands out: 'r', 'g', 'b', or '-' where all are alike.
char hue(const Rgb& c) {
  const int most = std::max({c.r, c.g, c.b}), least = std::min({c.r, c.g, c.b});
  if (most - least < 40) return '-';
  return most == c.r ? 'r' : most == c.g ? 'g' : 'b';
}

const std::vector<float> square_points = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
const std::vector<std::uint32_t> square_triangles = {0, 1, 2, 0, 2, 3};
const std::vector<float> square_uvs = {0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1};

Image draw_square(const Appearance* appearance) {
  const Resolution size = {.width = 80, .height = 80, .samples = 2};
  View view;
  view.margin = 0.1f;
  return render({.triangles = square_triangles, .points = square_points, .appearance = appearance},
                fit_camera(square_points, "y", view, 1), size);
}

}  // namespace

TEST_CASE("a texture is looked up with v upwards, mixes pixels, and goes on beyond its borders") {
  const auto texture = decode_texture(png_of(four_colours(8)), 64);
  REQUIRE(texture);
  CHECK(texture->width == 16);
  const float full = from_srgb({200.0f / 255, 0, 0}).x;
  const auto red_of = [&](float u, float v, TextureWrap wrap) { return texture->at(u, v, wrap, wrap)[0]; };
  CHECK(red_of(0.25f, 0.75f, TextureWrap::repeat) == doctest::Approx(full));
  CHECK(red_of(0.75f, 0.75f, TextureWrap::repeat) == doctest::Approx(0));
  CHECK(red_of(0.5f, 0.75f, TextureWrap::repeat) == doctest::Approx(full / 2));
  CHECK(texture->at(0.25f, 0.25f, TextureWrap::repeat, TextureWrap::repeat)[2] == doctest::Approx(full));
  CHECK(red_of(1.25f, -0.25f, TextureWrap::repeat) == doctest::Approx(full));
  CHECK(red_of(-0.25f, 1.25f, TextureWrap::mirror) == doctest::Approx(full));
  CHECK(red_of(1.25f, 0.75f, TextureWrap::mirror) == doctest::Approx(0));
  CHECK(red_of(-7, 9, TextureWrap::clamp) == doctest::Approx(full));
  CHECK(std::isfinite(red_of(NAN, INFINITY, TextureWrap::repeat)));
  CHECK(texture->at(0.5f, 0.5f, TextureWrap::clamp, TextureWrap::clamp)[3] == doctest::Approx(1));
}

TEST_CASE("a large texture is halved to means of its light, and what is no picture is none") {
  const auto texture = decode_texture(png_of(four_colours(32)), 2);
  REQUIRE(texture);
  CHECK(texture->width == 2);
  CHECK(texture->pixels[0][0] == red.r);
  CHECK(texture->pixels[1][1] == green.g);
  const auto one = decode_texture(png_of(four_colours(32)), 1);
  REQUIRE(one);
  const float mean = (from_srgb({200.0f / 255, 0, 0}).x + 1) / 4;
  CHECK(std::abs(one->pixels[0][0] - to_srgb({mean, 0, 0}).r) <= 1);

  std::vector<std::byte> cut = png_of(four_colours(8));
  cut.resize(cut.size() / 2);
  CHECK_FALSE(decode_texture(cut, 64));
  CHECK_FALSE(decode_texture({}, 64));
  CHECK_FALSE(decode_texture(std::vector<std::byte>(100, std::byte(0x89)), 64));
}

TEST_CASE("a surface shows its texture where the mesh has it") {
  Appearance appearance;
  appearance.textures.push_back(*decode_texture(png_of(four_colours(8)), 64));
  SurfaceColour textured = {{1, 1, 1}};
  textured.texture = 0;
  appearance.colours.push_back(textured);
  appearance.of_triangle = {0, 0};
  appearance.uvs = square_uvs;
  const Image image = draw_square(&appearance);
  CHECK(hue(image.at(25, 25)) == 'r');
  CHECK(hue(image.at(55, 25)) == 'g');
  CHECK(hue(image.at(25, 55)) == 'b');
  CHECK(hue(image.at(55, 55)) == '-');
  // Its factor colours it.
  appearance.colours[0].colour = {0, 1, 0};
  CHECK(hue(draw_square(&appearance).at(55, 55)) == 'g');
}

TEST_CASE("what is transparent is not there, and a mesh without materials is of clay") {
  Appearance appearance;
  appearance.colours.resize(2, {{0, 0, 1}});
  appearance.colours[1].alpha = 0.4f, appearance.colours[1].least_alpha = 0.5f;
  appearance.of_triangle = {0, 1};
  const Image image = draw_square(&appearance), plain = draw_square(nullptr);
  CHECK(hue(image.at(55, 60)) == 'b');  // the lower right triangle
  CHECK(image.at(25, 20) == image.at(0, 20));
  CHECK(hue(plain.at(25, 20)) == 'r');
  CHECK_FALSE(plain.at(25, 20) == plain.at(0, 20));
}

TEST_CASE("the part of a mesh that moves is found, and is the whole where most of it moves") {
  std::vector<float> body;
  for (int y = 0; y <= 20; ++y) body.insert(body.end(), {-1, float(y), 0, 1, float(y), 0});
  const std::vector<std::uint32_t> sizes, corners;
  const MeshView rest = {body, sizes, corners};
  MovingPart still(rest);
  still.add(body);
  CHECK_FALSE(still.region());

  std::vector<float> posed = body;
  for (std::size_t v = 2 * 18; v < posed.size() / 3; ++v) posed[3 * v + 2] += 0.5f;  // from y = 18 on
  MovingPart head(rest);
  head.add(body);
  head.add(posed);
  const auto region = head.region();
  REQUIRE(region);
  CHECK(region->low.y == doctest::Approx(17));
  CHECK(region->high.y == doctest::Approx(21));

  for (std::size_t v = 0; v < posed.size() / 3; ++v) posed[3 * v + 2] += 0.5f;
  head.add(posed);
  CHECK_FALSE(head.region());
}
