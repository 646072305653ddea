#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/surface.h"
#include "model/driven_joints.h"

namespace fb {

inline constexpr std::uint32_t no_material = 0xffffffff;

// Consecutive polygons of a mesh part that have the same material.
struct MaterialRun {
  std::uint32_t polygons = 0;            // at least 1
  std::uint32_t material = no_material;  // index of Character::materials
  bool operator==(const MaterialRun&) const = default;
};

// One of the meshes of a character: the vertices and polygons that follow those of the part before it. Its polygons use
// its own vertices only.
struct MeshPart {
  std::string name;            // unique, not empty
  std::uint32_t vertices = 0;  // at least 1
  std::uint32_t polygons = 0;
  std::vector<MaterialRun> materials = {};  // of all its polygons, in order
  bool operator==(const MeshPart&) const = default;
};

// The meshes of a character in one pool of vertices, as the source gave them: vertices are never merged, dropped or
// reordered; polygons keep their order and their first corner. Isolated, duplicate and non-manifold vertices are
// allowed.
struct Mesh {
  std::vector<float> points;                   // 3 x vertices, xyz interleaved
  std::vector<std::uint32_t> polygon_sizes;    // corners of each polygon, >= 3
  std::vector<std::uint32_t> polygon_corners;  // vertex indices, polygon after polygon
  // Texture coordinates, u and v interleaved, v pointing up from the lower edge of the image; and for each polygon
  // corner the index of its uv pair. A vertex on a seam has several. Both are empty without texture coordinates.
  std::vector<float> uvs = {};
  std::vector<std::uint32_t> uv_corners = {};
  std::vector<MeshPart> parts = {};    // of the surface and all polygons; empty: one mesh without a name
  DrivenJoints driven = {};            // what moves the surface, once its points are displaced
  std::uint32_t carrier_vertices = 0;  // the last vertices, that are no surface but carry numbers: see Channel and
                                       // DrivenJoints

  std::size_t vertex_count() const { return points.size() / 3; }
  std::size_t surface_vertex_count() const { return vertex_count() - carrier_vertices; }
  std::span<const float> surface_points() const { return std::span(points).first(3 * surface_vertex_count()); }
  // Length of the diagonal of the bounding box of the surface: the unit of reported errors.
  double diagonal() const { return box_diagonal(surface_points()); }
  // The coordinate that carries the first number of the driven joints.
  std::size_t first_joint_coordinate() const { return points.size() - (driven.number_count() + 2) / 3 * 3; }
  // Where the vertices of each part end, and those that carry numbers, if there are any: rows of the basis that belong
  // to different ones are in different row blocks.
  std::vector<std::uint32_t> part_ends() const;
  // 3 vertex indices a triangle, in polygon order.
  std::vector<std::uint32_t> triangles() const { return triangle_fans(polygon_sizes, polygon_corners); }
};

// Fails, naming the vertex or polygon, on an empty mesh, a point that is not finite, a polygon of fewer than three
// corners, a corner index out of range, texture coordinates that are not finite or not one a corner, parts
// that do not cover the mesh or share vertices, inconsistent counts, driven joints that break their rules, or a
// bounding box of zero size.
void check(const Mesh& mesh);

}  // namespace fb
