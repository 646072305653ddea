// Shapes are drawn with strokes: a soft brush at a place that moves the skin under it.
#pragma once

#include <vector>

#include "face_mesh.h"

namespace sample_face {

enum class On {
  all,
  upper,
  lower,
  face
};  // which side of the mouth a stroke holds on to; `face` leaves the lips alone

struct Stroke {
  Vec3 centre, radius;  // cm; nothing moves outside the ellipsoid
  Vec3 move;            // cm at the centre
  On on = On::all;
  float push = 0;  // cm along the skin's normal at the centre
  Vec3 grow{};     // cm a centimetre away from the centre: negative draws together
};

inline Stroke mirrored(Stroke s) {
  s.centre = mirrored(s.centre);
  s.move = mirrored(s.move);  // grow is the same on both sides
  return s;
}

// Displacements of some vertices.
struct Delta {
  std::vector<Index> vertices;
  std::vector<Vec3> moves;

  void apply(float weight, Vec3* points) const {
    for (std::size_t i = 0; i < vertices.size(); ++i) points[vertices[i]] += moves[i] * weight;
  }
};

// What strokes need to know about the skin.
struct Canvas {
  std::vector<Vec3> points, normals;
  std::vector<float> lower;     // 1 on the lower jaw's side, 0 above, soft between; sharp between the lips
  std::vector<float> lid_hold;  // 1 where the lids alone decide
  std::vector<float> lips;      // 1 on the lips
};

Canvas make_canvas(const FaceMesh& mesh, const std::vector<float>& jaw_weight);
Delta paint(const Canvas& canvas, const std::vector<Stroke>& strokes);
// A delta from a dense list; small displacements are dropped.
Delta sparse(const std::vector<Vec3>& moves);

}  // namespace sample_face
