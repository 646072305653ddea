// Surfaces that touch in the true pose, such as closed lips or lids on an eye, and how far a face moves them apart or
// into each other.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/regions/surface_graph.h"
#include "base/vector3.h"
#include "figures/quality_figures.h"
#include "model/mesh.h"

namespace fb::bake {

// A vertex p and the nearest point q of the triangle that it touches, q = sum of weights times corners.
struct TouchingPair {
  std::uint32_t vertex = 0;
  std::array<std::uint32_t, 3> corners = {};
  std::array<float, 3> weights = {};
  Vector3 direction;  // unit vector halfway between the normal at q and that at p reversed: they part along it
};

// Finds touching pairs, at most one a vertex. p and q touch if
//   |p - q| <= visible_gap D;
//   they face each other: the vertex normal at p and the normal of q's triangle are at least 120 degrees apart;
//   they are far apart along the rest surface: no corner of q's triangle is p's neighbour, or within 4 visible_gap D of
//   p along edges, where vertices at one place at rest that do not face each other, as on seams, count as joined;
//   the triangle has at least a hundredth of its area at rest: a rig may hide things by shrinking them;
//   and they are not the two sides of a thin sheet, which lie back to back (or as near as a tenth of visible_gap D),
//   and to within that tenth as far apart as at rest.
class ContactFinder {
 public:
  explicit ContactFinder(const Mesh& rest);

  // points: 3 x vertices; normals: of the vertices in that pose, see vertex_normals. By ascending vertex. Thread-safe.
  std::vector<TouchingPair> touching(std::span<const float> points, std::span<const Vector3> normals) const;

 private:
  // The place that a vertex touches.
  struct Nearest {
    float squared = INFINITY;  // distance
    TouchingPair pair;
  };
  struct Pose {
    std::span<const float> points;
    std::span<const Vector3> normals;
    std::vector<Nearest> nearest;      // by vertex
    std::vector<float> along_surface;  // by vertex: infinite between calls of far_along_surface
  };
  class Grid;

  void search(Pose& pose) const;
  void add_if_nearest(Pose& pose, std::uint32_t vertex, std::uint32_t triangle, Vector3 normal) const;
  bool same_sheet(const TouchingPair& pair, Vector3 apart) const;
  bool far_along_surface(const TouchingPair& pair, Pose& pose) const;

  float distance_;           // within which places touch
  std::vector<float> rest_;  // points
  SurfaceGraph graph_;
  std::vector<std::uint32_t> triangles_;
  std::vector<float> rest_sizes_;  // of triangles: twice their area
  float cell_;                     // size of cells
  std::array<std::uint64_t, 54> facing_parts_;
};

// Sums over frames; partial sums are joined with `append` in order, like ErrorSums.
class ContactSums {
 public:
  // frame: its number for worst_frame; error: over D, 3 x vertices.
  void add_frame(std::size_t frame, std::span<const TouchingPair> pairs, std::span<const float> error);
  // The frames of `later` have numbers from first_frame on.
  void append(const ContactSums& later, std::size_t first_frame);
  ContactErrors figures() const;

 private:
  double squares_ = 0;                             // of gaps
  double touching_squares_ = 0, all_squares_ = 0;  // of distances: of vertices that touch something, and of all
  std::size_t vertices_ = 0;                       // of all frames
  ContactErrors errors_;
};

}  // namespace fb::bake
