#include "render/rasterizer.h"

#include <algorithm>
#include <cmath>

#include "model/surface.h"
#include "render/ambient_occlusion.h"
#include "render/colour_map.h"
#include "render/shading.h"

namespace fb {
namespace {

// A vertex after projection: sample coordinates, and 1 / distance, which is linear over the picture.
struct Projected {
  float x = 0, y = 0, inverse_distance = 0;  // 0: behind the camera
};

struct Prepared {
  const Scene& scene;
  std::vector<Projected> projected;
  std::vector<Vector3> eye_points, eye_normals;  // camera space
  std::vector<float> ambient_occlusion;
};

Prepared prepare(const Scene& scene, const Camera& camera, int width, int height, const Parallel& parallel) {
  Prepared p{scene, {}, {}, {}, {}};
  const std::size_t vertices = scene.points.size() / 3;
  const auto normals = vertex_normals(scene.triangles, scene.points);
  p.ambient_occlusion = vertex_exposure(scene.triangles, scene.points, normals, parallel);
  p.projected.resize(vertices);
  p.eye_points.resize(vertices);
  p.eye_normals.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    const Vector3 e = camera.to_camera(vector_at(scene.points.data(), v));
    p.eye_points[v] = e;
    p.eye_normals[v] = {dot(normals[v], camera.right), dot(normals[v], camera.up), dot(normals[v], camera.back)};
    if (!(e.z < 0)) continue;
    const float inverse = -1 / e.z;
    p.projected[v] = {(e.x * inverse * camera.focal / camera.aspect + 1) * 0.5f * width,
                      (1 - e.y * inverse * camera.focal) * 0.5f * height, inverse};
  }
  return p;
}

// The nearest triangle of every sample of a band of rows, and where in it the sample lies (perspective-correct).
struct Hit {
  std::uint32_t triangle = UINT32_MAX;
  float nearness = 0, b = 0, c = 0;
};

void rasterize(const Prepared& p, int first_row, int rows, int width, std::vector<Hit>& hits) {
  hits.assign(static_cast<std::size_t>(rows) * width, {});
  const auto& triangles = p.scene.triangles;
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const Projected &a = p.projected[triangles[t]], &b = p.projected[triangles[t + 1]],
                    &c = p.projected[triangles[t + 2]];
    if (!(a.inverse_distance > 0 && b.inverse_distance > 0 && c.inverse_distance > 0)) continue;
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
        const float nearness = wa * a.inverse_distance + wb * b.inverse_distance + wc * c.inverse_distance;
        Hit& hit = hits[static_cast<std::size_t>(y - first_row) * width + x];
        if (nearness <= hit.nearness) continue;
        hit = {static_cast<std::uint32_t>(t), nearness, wb * b.inverse_distance / nearness,
               wc * c.inverse_distance / nearness};
      }
  }
}

Vector3 shade(const Prepared& p, const Hit& hit) {
  const std::uint32_t* corner = &p.scene.triangles[hit.triangle];
  const auto blend = [&](const auto& values) {
    return values[corner[0]] * (1 - hit.b - hit.c) + values[corner[1]] * hit.b + values[corner[2]] * hit.c;
  };
  Vector3 normal = normalized(blend(p.eye_normals));
  const Vector3 to_eye = normalized(blend(p.eye_points) * -1.0f);
  const Vector3 flat =
      cross(p.eye_points[corner[1]] - p.eye_points[corner[0]], p.eye_points[corner[2]] - p.eye_points[corner[0]]);
  const bool inside = dot(flat, to_eye) < 0;
  if (inside) normal = normal * -1.0f;
  const float ambient_occlusion = inside ? 0.1f : blend(p.ambient_occlusion);
  if (!p.scene.scalars.empty())
    return shade_map(normal, ambient_occlusion, map_colour(blend(p.scene.scalars), p.scene.scalar_full));
  return shade_clay(normal, to_eye, ambient_occlusion, clay);
}

}  // namespace

Image render(const Scene& scene, const Camera& camera, const Canvas& canvas, const Parallel& parallel) {
  const int samples = canvas.samples, width = canvas.width * samples, height = canvas.height * samples;
  const Prepared prepared = prepare(scene, camera, width, height, parallel);
  Image image(canvas.width, canvas.height);
  constexpr int band = 16;  // rows of pixels drawn as one piece of work
  const std::size_t bands = (canvas.height + band - 1) / band;
  parallel_for(parallel, bands, [&](std::size_t index, std::size_t) {
    const int first = static_cast<int>(index) * band, rows = std::min(band, canvas.height - first);
    std::vector<Hit> hits;
    rasterize(prepared, first * samples, rows * samples, width, hits);
    for (int y = 0; y < rows; ++y) {
      const Vector3 behind = backdrop((first + y + 0.5f) / canvas.height);
      for (int x = 0; x < canvas.width; ++x) {
        Vector3 sum;
        for (int s = 0; s < samples * samples; ++s) {
          const Hit& hit =
              hits[(static_cast<std::size_t>(y) * samples + s / samples) * width + x * samples + s % samples];
          sum = sum + (hit.triangle == UINT32_MAX ? behind : shade(prepared, hit));
        }
        image.at(x, first + y) = to_srgb(sum * (1.0f / (samples * samples)));
      }
    }
  });
  return image;
}

}  // namespace fb
