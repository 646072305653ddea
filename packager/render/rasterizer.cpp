#include "render/rasterizer.h"

#include <algorithm>
#include <cmath>

#include "base/surface.h"
#include "render/ambient_occlusion.h"
#include "render/colour_map.h"
#include "render/shading.h"

namespace fb::tool {
namespace {

constexpr float whitest = 0.7f;  // albedo of what a material calls white: more would be white in every light

// A vertex after projection: sample coordinates, and 1 / depth, which is linear over the image.
struct Projected {
  float x = 0, y = 0, inverse_depth = 0;  // 0: behind the camera
};

// What all bands of rows read.
struct TransformedScene {
  const Scene& scene;
  std::vector<Projected> projected;
  std::vector<Vector3> points, normals;  // camera space
  std::vector<float> ambient_occlusion;
  const Appearance* appearance = nullptr;  // null: in one colour, or colours that are not the surface's own
};

TransformedScene transform(const Scene& scene, const Camera& camera, int width, int height, const Parallel& parallel) {
  TransformedScene p{scene, {}, {}, {}, {}};
  if (scene.scalars.empty() && scene.colours.empty()) p.appearance = scene.appearance;
  const std::size_t vertices = scene.points.size() / 3;
  const auto normals = vertex_normals(scene.triangles, scene.points);
  p.ambient_occlusion = vertex_ambient_occlusion(scene.triangles, scene.points, normals, parallel);
  p.projected.resize(vertices);
  p.points.resize(vertices);
  p.normals.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    const Vector3 e = camera.to_camera(vector_at(scene.points.data(), v));
    p.points[v] = e;
    p.normals[v] = {dot(normals[v], camera.right), dot(normals[v], camera.up), dot(normals[v], camera.back)};
    if (!(e.z < 0)) continue;
    const float inverse = -1 / e.z;
    p.projected[v] = {(e.x * inverse * camera.focal / camera.aspect + 1) * 0.5f * width,
                      (1 - e.y * inverse * camera.focal) * 0.5f * height, inverse};
  }
  return p;
}

// The nearest triangle of a sample, with perspective-correct barycentric coordinates of its corners b and c.
struct Hit {
  std::uint32_t triangle = UINT32_MAX;  // none
  float inverse_depth = 0, b = 0, c = 0;
};

// The hits of all samples of a band of rows.
void rasterize(const TransformedScene& p, int first_row, int rows, int width, std::vector<Hit>& hits) {
  hits.assign(static_cast<std::size_t>(rows) * width, {});
  const auto& triangles = p.scene.triangles;
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const Projected &a = p.projected[triangles[t]], &b = p.projected[triangles[t + 1]],
                    &c = p.projected[triangles[t + 2]];
    if (!(a.inverse_depth > 0 && b.inverse_depth > 0 && c.inverse_depth > 0)) continue;
    const float low_y = std::min({a.y, b.y, c.y}), high_y = std::max({a.y, b.y, c.y});
    if (high_y < first_row || low_y > first_row + rows) continue;
    const float twice_area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(std::fabs(twice_area) > 1e-12f)) continue;
    const auto bounded = [](float value, int low, int high) {
      return static_cast<int>(std::clamp(value, static_cast<float>(low), static_cast<float>(high)));
    };
    const int y0 = bounded(low_y - 0.5f, first_row, first_row + rows - 1);
    const int y1 = bounded(high_y + 0.5f, first_row, first_row + rows - 1);
    const int x0 = bounded(std::min({a.x, b.x, c.x}) - 0.5f, 0, width - 1);
    const int x1 = bounded(std::max({a.x, b.x, c.x}) + 0.5f, 0, width - 1);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const float px = x + 0.5f, py = y + 0.5f;
        const float wb = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / twice_area;
        const float wc = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / twice_area;
        const float wa = 1 - wb - wc;
        if (wa < 0 || wb < 0 || wc < 0) continue;
        const float inverse_depth = wa * a.inverse_depth + wb * b.inverse_depth + wc * c.inverse_depth;
        Hit& hit = hits[static_cast<std::size_t>(y - first_row) * width + x];
        if (inverse_depth <= hit.inverse_depth) continue;
        const Hit nearer = {static_cast<std::uint32_t>(t), inverse_depth, wb * b.inverse_depth / inverse_depth,
                            wc * c.inverse_depth / inverse_depth};
        if (!p.appearance || p.appearance->at(t / 3, nearer.b, nearer.c).covers) hit = nearer;
      }
  }
}

Vector3 shade(const TransformedScene& p, const Hit& hit) {
  const std::uint32_t* corner = &p.scene.triangles[hit.triangle];
  const auto interpolate = [&](const auto& values) {
    return values[corner[0]] * (1 - hit.b - hit.c) + values[corner[1]] * hit.b + values[corner[2]] * hit.c;
  };
  Vector3 normal = normalized(interpolate(p.normals));
  const Vector3 to_eye = normalized(interpolate(p.points) * -1.0f);
  const Vector3 face_normal =
      cross(p.points[corner[1]] - p.points[corner[0]], p.points[corner[2]] - p.points[corner[0]]);
  const bool back_face = dot(face_normal, to_eye) < 0;
  if (back_face) normal = normal * -1.0f;
  const float ambient_occlusion = back_face ? 0.1f : interpolate(p.ambient_occlusion);
  if (!p.scene.scalars.empty())
    return shade_colour_map(normal, ambient_occlusion, map_colour(interpolate(p.scene.scalars), p.scene.scale));
  if (!p.scene.colours.empty()) return shade_colour_map(normal, ambient_occlusion, interpolate(p.scene.colours));
  if (!p.appearance) return shade_clay(normal, to_eye, ambient_occlusion, clay);
  const Appearance::Seen seen = p.appearance->at(hit.triangle / 3, hit.b, hit.c);
  return shade_clay(normal, to_eye, ambient_occlusion, seen.colour * whitest) + seen.emissive;
}

}  // namespace

Image render(const Scene& scene, const Camera& camera, const Resolution& resolution, const Parallel& parallel) {
  const int samples = resolution.samples, width = resolution.width * samples, height = resolution.height * samples;
  const TransformedScene transformed = transform(scene, camera, width, height, parallel);
  Image image(resolution.width, resolution.height);
  constexpr int band = 16;  // rows of pixels a task
  const std::size_t bands = (resolution.height + band - 1) / band;
  parallel_for(parallel, bands, [&](std::size_t index, std::size_t) {
    const int first = static_cast<int>(index) * band, rows = std::min(band, resolution.height - first);
    std::vector<Hit> hits;
    rasterize(transformed, first * samples, rows * samples, width, hits);
    for (int y = 0; y < rows; ++y) {
      const Vector3 behind = background((first + y + 0.5f) / resolution.height);
      for (int x = 0; x < resolution.width; ++x) {
        Vector3 sum;
        for (int s = 0; s < samples * samples; ++s) {
          const Hit& hit =
              hits[(static_cast<std::size_t>(y) * samples + s / samples) * width + x * samples + s % samples];
          sum = sum + (hit.triangle == UINT32_MAX ? behind : shade(transformed, hit));
        }
        image.at(x, first + y) = to_srgb(sum * (1.0f / (samples * samples)));
      }
    }
  });
  return image;
}

}  // namespace fb::tool
