// Draws posed meshes without a graphics card: the same pixels everywhere, whatever the thread count.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "render/camera.h"
#include "render/image.h"

namespace fb {

struct Scene {
  std::span<const std::uint32_t> triangles;  // three vertex indices each
  std::span<const float> points;             // 3 x vertices
  std::span<const float> scalars = {};       // one a vertex: coloured by map_colour; empty: clay
  float scalar_full = 1;                     // the scalar at the end of the colour map
};

struct Canvas {
  int width = 640, height = 800;
  int samples = 3;  // samples x samples rays a pixel
};

// Both sides of a surface are drawn, the inside darker. Triangles that reach behind the camera are left out.
Image render(const Scene& scene, const Camera& camera, const Canvas& canvas, const Parallel& parallel = {});

}  // namespace fb
