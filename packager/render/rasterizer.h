// A software rasteriser: the same pixels on every machine, whatever the number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "render/appearance.h"
#include "render/camera.h"
#include "render/colour_map.h"
#include "render/image.h"

namespace fb::tool {

struct Scene {
  std::span<const std::uint32_t> triangles;  // three vertex indices each
  std::span<const float> points;             // 3 x vertices
  std::span<const float> scalars = {};       // one a vertex, coloured by map_colour; empty: a clay render
  ColourScale scale = {};                    // of the scalars
  std::span<const Vector3> colours = {};     // one a vertex, linear RGB, instead of scalars
  // In place of clay, without scalars and colours: see Appearance, of these triangles.
  const Appearance* appearance = nullptr;
};

struct Resolution {
  int width = 640, height = 800;
  int samples = 3;  // supersampling: samples x samples a pixel
};

// Both sides of a surface are drawn, the back faces darker. Triangles that reach behind the camera are left out.
Image render(const Scene& scene, const Camera& camera, const Resolution& resolution, const Parallel& parallel = {});

}  // namespace fb::tool
