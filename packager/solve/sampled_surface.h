// A surface that others are aligned with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/camera.h"
#include "render/mesh_view.h"
#include "solve/open_border.h"
#include "solve/triangle_tree.h"

namespace fb::tool {

// Points of a surface with their unit normals.
struct SurfaceSamples {
  std::vector<Vector3> points, normals;
};

// `count` points spread evenly by area over the triangles in their order, one in the middle of each equal share of the
// area, at places of their triangles that follow a low-discrepancy sequence; always the same.
SurfaceSamples sample_surface(std::span<const float> points, std::span<const std::uint32_t> triangles,
                              std::size_t count);

// What alignment and correspondences ask of a mesh.
struct SampledSurface {
  // Fails with bad_data where the mesh has no surface.
  SampledSurface(const MeshView& mesh, std::size_t samples);

  std::vector<float> points;             // 3 x vertices
  std::vector<std::uint32_t> triangles;  // fans of its polygons
  TriangleTree tree;
  OpenBorder border;
  SurfaceSamples samples;
  BoundingBox box;  // of the samples
  double diagonal;  // of that box
};

BoundingBox box_of(std::span<const Vector3> points);

}  // namespace fb::tool
