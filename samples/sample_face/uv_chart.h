// A part of the surface laid flat. Points on its edge, and any others, are placed; every other point comes to lie
// between its neighbours, so that with a convex edge nothing overlaps (Tutte, "How to draw a graph", 1963).
#pragma once

#include <functional>
#include <unordered_map>
#include <vector>

#include "face_mesh.h"

namespace sample_face {

struct Uv {
  float u = 0, v = 0;
};

// Texture coordinates of the mesh: pairs, and for each quad the pairs of its corners.
struct FaceUvs {
  std::vector<Uv> pairs;
  std::vector<std::array<Index, 4>> corners;
};

class Chart {
 public:
  // quads: indices of quads of the mesh. Along the seam those on the -x side have points of their own.
  Chart(const FaceMesh& mesh, std::vector<Index> quads, const Ring& seam = {});

  // The chart's point of a vertex of the mesh; on the seam that of the +x side, with `copy` the other one.
  Index point(Index vertex, bool copy = false) const { return (copy ? copies_ : points_).at(vertex); }
  void place(Index point, Uv at);
  // Where points that are not placed begin.
  void start(const std::function<Uv(Vec3)>& at);
  // A hole in the chart, which keeps its room.
  void add_hole(const Ring& ring);

  // Finds where the points are that were not placed. In each pass those of triangles that came out too small are drawn
  // further apart (Yoshizawa, Belyaev and Seidel, "A fast and simple stretch-minimizing mesh parameterization", 2004).
  // scale: how large the surface is to be at a point, 1 being as it is.
  void relax(int passes, int sweeps, const std::function<float(Vec3)>& scale);

  void add_to(FaceUvs& uvs) const;

 private:
  struct Link {
    Index to;
    float weight;
  };
  void link(Index a, Index b);
  void solve(int sweeps);
  std::vector<float> stretches(const std::function<float(Vec3)>& scale) const;

  std::vector<Index> quads_;
  std::vector<std::array<Index, 4>> corners_;  // of each, its points
  std::unordered_map<Index, Index> points_, copies_;
  std::vector<Vec3> places_;  // on the surface
  std::vector<Uv> at_;
  std::vector<bool> placed_;
  std::vector<std::vector<Link>> links_;
};

}  // namespace sample_face
