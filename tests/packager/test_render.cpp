// Properties of rendered images that do not depend on exact pixels.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/surface.h"
#include "render/ambient_occlusion.h"
#include "render/colour_map.h"
#include "render/montage.h"
#include "render/png_file.h"
#include "render/pose_renderer.h"
#include "render/rasterizer.h"
#include "render/shading.h"
#include "render/text.h"

using namespace fb;
using namespace fb::tool;

namespace {

struct Shape {
  std::vector<float> points;
  std::vector<std::uint32_t> triangles;
};

// A square of side 2 that faces +z.
Shape square(float z = 0) {
  return {{-1, -1, z, 1, -1, z, 1, 1, z, -1, 1, z}, {0, 1, 2, 0, 2, 3}};
}

// A sphere of radius 1 from rings and segments, mirror-symmetric in x.
Shape sphere(std::uint32_t rings = 24, std::uint32_t segments = 48) {
  Shape shape;
  for (std::uint32_t r = 0; r <= rings; ++r)
    for (std::uint32_t s = 0; s < segments; ++s) {
      const double latitude = M_PI * r / rings, longitude = 2 * M_PI * (s + 0.5) / segments;
      shape.points.insert(shape.points.end(),
                          {float(std::sin(latitude) * std::sin(longitude)), float(std::cos(latitude)),
                           float(std::sin(latitude) * std::cos(longitude))});
    }
  for (std::uint32_t r = 0; r < rings; ++r)
    for (std::uint32_t s = 0; s < segments; ++s) {
      const std::uint32_t a = r * segments + s, b = r * segments + (s + 1) % segments;
      shape.triangles.insert(shape.triangles.end(), {a, a + segments, b, b, a + segments, b + segments});
    }
  return shape;
}

// Pixels that show something: the background is constant along a row, and the first column is always background.
std::vector<bool> silhouette(const Image& image) {
  std::vector<bool> covered(image.pixels.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      covered[std::size_t(y) * image.width + x] = !(image.at(x, y) == image.at(0, y));
  return covered;
}

double share(const std::vector<bool>& covered) {
  return double(std::count(covered.begin(), covered.end(), true)) / covered.size();
}

std::vector<bool> mirrored(const std::vector<bool>& covered, int width) {
  std::vector<bool> other(covered.size());
  for (std::size_t i = 0; i < covered.size(); ++i) other[i] = covered[i / width * width + width - 1 - i % width];
  return other;
}

std::size_t differing(const std::vector<bool>& a, const std::vector<bool>& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
  return count;
}

const Resolution small = {.width = 160, .height = 160, .samples = 2};

Image draw(const Shape& shape, const View& view = {}, const std::vector<float>& scalars = {}, float full = 1) {
  return render({.triangles = shape.triangles, .points = shape.points, .scalars = scalars, .scale = {full}},
                fit_camera(shape.points, "y", view, 1), small);
}

}  // namespace

TEST_CASE("the camera fits all points into the image, up to the margin") {
  View view;
  view.margin = 0.1f;
  CHECK(share(silhouette(draw(square(), view))) == doctest::Approx(0.8 * 0.8).epsilon(0.03));
  // A sphere's outline is a circle that touches the margins.
  CHECK(share(silhouette(draw(sphere(), view))) == doctest::Approx(M_PI / 4 * 0.8 * 0.8).epsilon(0.05));
}

TEST_CASE("with a region, only its points must be in the image") {
  const Shape shape = sphere();
  View view;
  view.region = BoundingBox{{-0.3f, -0.3f, 0.5f}, {0.3f, 0.3f, 2}};
  const Camera near = fit_camera(shape.points, "y", view, 1), whole = fit_camera(shape.points, "y", {}, 1);
  CHECK(near.position.z < 0.7f * whole.position.z);
  float farthest = 0;  // from the middle of the picture; 1 is its edge
  for (std::size_t v = 0; v < shape.points.size() / 3; ++v) {
    const Vector3 p = vector_at(shape.points.data(), v);
    if (std::fabs(p.x) > 0.3f || std::fabs(p.y) > 0.3f || p.z < 0.5f) continue;
    const Vector3 e = near.to_camera(p);
    farthest = std::max({farthest, std::fabs(e.x / e.z) * near.focal, std::fabs(e.y / e.z) * near.focal});
  }
  CHECK(farthest == doctest::Approx(1 - 2 * view.margin));
}

TEST_CASE("a symmetric shape has a symmetric silhouette, and opposite views mirrored ones") {
  const auto front = silhouette(draw(sphere()));
  CHECK(differing(front, mirrored(front, small.width)) < 10);
  Shape lopsided = sphere();
  for (std::size_t i = 0; i < lopsided.points.size(); i += 3)
    if (lopsided.points[i + 2] > 0.5f) lopsided.points[i + 2] *= 2;  // a snout
  View left, right;
  left.yaw = -40;
  right.yaw = 40;
  const auto from_left = silhouette(draw(lopsided, left)), from_right = silhouette(draw(lopsided, right));
  CHECK(differing(from_left, mirrored(from_right, small.width)) < 10);
  CHECK(differing(from_left, from_right) > 500);
}

TEST_CASE("a z-up mesh looks like the y-up mesh rotated") {
  Shape shape = sphere();
  for (std::size_t i = 0; i < shape.points.size(); i += 3) shape.points[i + 1] *= 1.4f;
  Shape turned = shape;
  for (std::size_t i = 0; i < shape.points.size(); i += 3) {
    turned.points[i + 1] = -shape.points[i + 2];
    turned.points[i + 2] = shape.points[i + 1];
  }
  View view;
  view.yaw = 25;
  view.pitch = 15;
  const Image a = draw(shape, view);
  const Image b =
      render({.triangles = turned.triangles, .points = turned.points}, fit_camera(turned.points, "z", view, 1), small);
  CHECK(differing(silhouette(a), silhouette(b)) < 10);
  const Rgb middle_a = a.at(80, 80), middle_b = b.at(80, 80);
  CHECK(std::abs(middle_a.r - middle_b.r) <= 2);
}

TEST_CASE("the nearer surface is seen, whatever the order of triangles") {
  for (const bool front_first : {false, true}) {
    Shape both = square(front_first ? 1.0f : -1.0f);
    const Shape other = square(front_first ? -1.0f : 1.0f);
    both.points.insert(both.points.end(), other.points.begin(), other.points.end());
    for (const std::uint32_t corner : square().triangles) both.triangles.push_back(corner + 4);
    const float first = front_first ? 1.0f : 0.0f;
    const Image image = draw(both, {}, {first, first, first, first, 1 - first, 1 - first, 1 - first, 1 - first});
    const Rgb seen = image.at(80, 80), full = to_srgb(shade_colour_map({0, 0, 1}, 1, map_colour(1, {1})));
    CHECK(std::abs(seen.r - full.r) <= 2);
    CHECK(std::abs(seen.g - full.g) <= 2);
  }
}

TEST_CASE("an error map shows known values in the colours of its scale") {
  for (const float value : {0.0f, 0.25f, 0.5f, 1.0f, 3.0f}) {
    const Image image = draw(square(), {}, std::vector<float>(4, value), 1);
    const Rgb seen = image.at(80, 80), expected = to_srgb(shade_colour_map({0, 0, 1}, 1, map_colour(value, {1})));
    CHECK(std::abs(seen.r - expected.r) <= 2);
    CHECK(std::abs(seen.g - expected.g) <= 2);
    CHECK(std::abs(seen.b - expected.b) <= 2);
  }
  // Lightness decreases from no error to full error, so that the map also reads in grey.
  float before = 2;
  for (int i = 0; i <= 20; ++i) {
    const Vector3 colour = map_colour(i / 20.0f, {1});
    const float luminance = dot(colour, {0.2126f, 0.7152f, 0.0722f});
    CHECK(luminance < before);
    before = luminance;
  }
  CHECK(to_srgb(map_colour(9, {1})) == to_srgb(map_colour(1, {1})));
}

TEST_CASE("a comparison measures over the diagonal and uses the given scale") {
  const Shape shape = square();
  const std::vector<std::uint32_t> sizes = {4}, corners = {0, 1, 2, 3};
  const MeshView rest = {shape.points, sizes, corners};
  std::vector<float> off = shape.points;
  for (std::size_t v = 0; v < 4; ++v) off[3 * v + 2] -= 0.2f;
  const double distance = 0.2 / std::sqrt(8.0);
  const PoseRenderer renderer(rest, {}, "y", {}, small, {});
  for (const float full : {0.0f, 0.4f}) {
    const PoseRenderer::Comparison beside =
        renderer.draw_comparison({"truth", shape.points}, {{"archive", off}}, {{full}});
    const PoseRenderer::Difference difference = beside.differences.at(0);
    CHECK(difference.max == doctest::Approx(distance));
    CHECK(difference.rms == doctest::Approx(distance));
    const float scale = full > 0 ? full : round_scale(float(distance));
    const Rgb seen = beside.image.at(3 * 8 + 2 * 160 + 80, 8 + 80),
              expected = to_srgb(shade_colour_map({0, 0, 1}, 1, map_colour(float(distance), {scale})));
    CHECK(std::abs(seen.r - expected.r) <= 2);
    CHECK(std::abs(seen.g - expected.g) <= 2);
    CHECK(std::abs(seen.b - expected.b) <= 2);
  }
  off[2] = shape.points[2];  // one of four is where it belongs
  const PoseRenderer::Difference three =
      renderer.draw_comparison({"truth", shape.points}, {{"archive", off}}, {{0}}).differences.at(0);
  CHECK(three.max == doctest::Approx(distance));
  CHECK(three.rms == doctest::Approx(distance * std::sqrt(0.75)));
}

TEST_CASE("scales end on 1, 2 or 5") {
  CHECK(round_scale(0.0013f) == doctest::Approx(0.002));
  CHECK(round_scale(0.0021f) == doctest::Approx(0.005));
  CHECK(round_scale(0.3f) == doctest::Approx(0.5));
  CHECK(round_scale(0) == doctest::Approx(1e-6));
}

TEST_CASE("a sphere has outward normals, and ambient occlusion inside only") {
  const Shape shape = sphere();
  auto normals = vertex_normals(shape.triangles, shape.points);
  for (std::size_t v = 0; v < normals.size(); ++v) CHECK(dot(normals[v], vector_at(shape.points.data(), v)) > 0.98f);
  for (const float ambient_occlusion : vertex_ambient_occlusion(shape.triangles, shape.points, normals, {}))
    CHECK(ambient_occlusion > 0.97f);
  for (Vector3& n : normals) n = n * -1.0f;
  for (const float ambient_occlusion : vertex_ambient_occlusion(shape.triangles, shape.points, normals, {}))
    CHECK(ambient_occlusion < 0.1f);
}

TEST_CASE("a wall occludes half of the sky of the floor beside it") {
  // The floor y = 0 reaches from the wall x = 0 to x = 4; both are cut fine.
  Shape corner;
  const int steps = 40;
  const auto sheet = [&](Vector3 origin, Vector3 along, Vector3 across) {
    const auto first = static_cast<std::uint32_t>(corner.points.size() / 3);
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; j <= steps; ++j) {
        const Vector3 p = origin + along * (float(i) / steps) + across * (float(j) / steps);
        corner.points.insert(corner.points.end(), {p.x, p.y, p.z});
      }
    for (std::uint32_t i = 0; i < steps; ++i)
      for (std::uint32_t j = 0; j < steps; ++j) {
        const std::uint32_t a = first + i * (steps + 1) + j, b = a + steps + 1;
        corner.triangles.insert(corner.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
      }
  };
  sheet({0, 0, -2}, {0, 0, 4}, {4, 0, 0});
  sheet({0, 0, -2}, {0, 4, 0}, {0, 0, 4});
  const std::vector<Vector3> upward(corner.points.size() / 3, {0, 1, 0});
  const auto ambient_occlusion = vertex_ambient_occlusion(corner.triangles, corner.points, upward, {});
  const auto on_floor = [&](int i, int j) { return ambient_occlusion[i * (steps + 1) + j]; };
  CHECK(on_floor(steps / 2, 3) == doctest::Approx(0.55).epsilon(0.15));
  CHECK(on_floor(steps / 2, steps) > 0.8f);
  CHECK(on_floor(steps / 2, 3) < on_floor(steps / 2, steps / 2));
}

TEST_CASE("images do not depend on the number of threads") {
  const Shape shape = sphere();
  const Scene scene = {.triangles = shape.triangles, .points = shape.points};
  const Camera camera = fit_camera(shape.points, "y", {}, 1);
  CHECK(render(scene, camera, small, {.threads = 1}).pixels == render(scene, camera, small, {.threads = 4}).pixels);
}

TEST_CASE("points behind the camera and empty meshes do no harm") {
  Shape shape = sphere();
  Camera camera = fit_camera(shape.points, "y", {}, 1);
  camera.position = {0, 0, 0};
  CHECK(render({.triangles = shape.triangles, .points = shape.points}, camera, small).pixels.size() == 160 * 160);
  CHECK(share(silhouette(render({.triangles = {}, .points = {}}, fit_camera({}, "y", {}, 1), small))) == 0);
}

TEST_CASE("a montage has its panels side by side with a colour bar, and text is clipped to the image") {
  const Image red(100, 80, {255, 0, 0}), blue(100, 80, {0, 0, 255});
  const Image plain = make_montage({{red, "left", {}}, {blue, "right", {}}});
  const Image scaled = make_montage({{red, "left", {}}, {blue, "right", ColourBar{{0.5f}}}});
  CHECK(plain.width > 200);
  CHECK(plain.height > 80 + text_height(1));
  CHECK(scaled.width > plain.width);
  CHECK(std::count(plain.pixels.begin(), plain.pixels.end(), Rgb{255, 0, 0}) == 8000);
  CHECK(std::count(plain.pixels.begin(), plain.pixels.end(), Rgb{0, 0, 255}) == 8000);
  Image page(40, 20, {255, 255, 255});
  draw_text(page, 2, 2, "max", {0, 0, 0}, 1);
  const auto inked = std::count(page.pixels.begin(), page.pixels.end(), Rgb{0, 0, 0});
  CHECK(inked > 20);
  CHECK(inked < 200);
  draw_text(page, -30, -5, "cut off on every side, \xc3\xa4 too", {0, 0, 0}, 3);
}

TEST_CASE("no pose that is drawn leaves the picture, whatever its shape and the view") {
  const Shape shape = sphere(12, 24);
  const std::vector<std::uint32_t> sizes(shape.triangles.size() / 3, 3);
  const MeshView rest = {shape.points, sizes, shape.triangles};
  // A jaw that drops by twice the head, and a head that leans out to the side.
  std::vector<float> open = shape.points, lean = shape.points;
  for (std::size_t v = 0; v < shape.points.size() / 3; ++v) {
    if (shape.points[3 * v + 1] < -0.5f) open[3 * v + 1] -= 2;
    lean[3 * v] += 3 * (shape.points[3 * v + 1] + 1);
  }
  const auto leaving = [&](const PoseRenderer& renderer, std::span<const float> points) {
    std::size_t triangles = 0;
    for (std::size_t t = 0; t < shape.triangles.size(); t += 3) {
      bool out = false;
      for (std::size_t k = t; k < t + 3; ++k)
        for (const float at : renderer.camera().project(vector_at(points.data(), shape.triangles[k])))
          out |= !(at >= 0 && at <= 1);
      triangles += out;
    }
    return triangles;
  };
  for (const Resolution resolution : {Resolution{80, 160, 1}, {160, 160, 1}, {240, 80, 1}})
    for (const float yaw : {0.0f, 50.0f, -120.0f}) {
      View view;
      view.yaw = yaw;
      view.pitch = 20;
      const PoseRenderer renderer(rest, {open, lean}, "y", view, resolution, {});
      CHECK(leaving(renderer, shape.points) == 0);
      CHECK(leaving(renderer, open) == 0);
      CHECK(leaving(renderer, lean) == 0);
      CHECK(leaving(PoseRenderer(rest, {}, "y", view, resolution, {}), lean) > 0);
    }
}

TEST_CASE("a logarithmic scale has three decades, and its ticks rise to its end") {
  const ColourScale scale{0.05f, true};
  CHECK(scale.position(0.05f) == 1);
  CHECK(scale.position(1) == 1);
  CHECK(scale.position(0.005f) == doctest::Approx(2.0 / 3));
  CHECK(scale.position(5e-5f) == doctest::Approx(0));
  CHECK(scale.position(0) == 0);
  const std::vector<float> ticks = scale.ticks();
  CHECK(ticks.front() == doctest::Approx(5e-5f));
  CHECK(ticks.back() == 0.05f);
  for (std::size_t i = 0; i < ticks.size(); ++i)
    CHECK(scale.position(ticks[i]) == doctest::Approx(double(i) / double(ticks.size() - 1)));
  CHECK(make_montage({{Image(100, 80), "", ColourBar{scale, 38.7, "cm"}}}).width >
        make_montage({{Image(100, 80), "", ColourBar{scale}}}).width);
}

TEST_CASE("parts are drawn in their colours, and numbered where they are seen") {
  const Shape shape = square();
  const std::vector<std::uint32_t> sizes = {4}, corners = {0, 1, 2, 3};
  const PoseRenderer renderer({shape.points, sizes, corners}, {}, "y", {}, small, {});
  for (const std::size_t part : {0, 1, 7}) {
    const Rgb own = part_colour(part);
    const Image image = renderer.draw_parts(shape.points, std::vector<std::size_t>(4, part), 8);
    const Vector3 colour = {float(own.r) / 255, float(own.g) / 255, float(own.b) / 255};
    const Rgb seen = image.at(40, 80), expected = to_srgb(shade_colour_map({0, 0, 1}, 1, from_srgb(colour)));
    CHECK(std::abs(seen.r - expected.r) <= 2);
    CHECK(std::abs(seen.g - expected.g) <= 2);
    CHECK(std::abs(seen.b - expected.b) <= 2);
  }
  const Shape ball = sphere();
  const std::vector<std::uint32_t> threes(ball.triangles.size() / 3, 3);
  const PoseRenderer round({ball.points, threes, ball.triangles}, {}, "y", {}, small, {});
  std::vector<std::size_t> parts(ball.points.size() / 3);
  const auto ink = [&] {
    const Image image = round.draw_parts(ball.points, parts, 2);
    return std::count(image.pixels.begin(), image.pixels.end(), Rgb{0, 0, 0});
  };
  CHECK(ink() > 5);
  std::fill(parts.begin(), parts.end(), 2);  // none
  CHECK(ink() == 0);
}
