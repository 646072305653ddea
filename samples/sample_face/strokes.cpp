#include "strokes.h"

#include "skin_weights.h"

namespace sample_face {

Canvas make_canvas(const FaceMesh& mesh, const std::vector<float>& jaw_weight) {
  const std::size_t count = mesh.skin.count;
  Canvas canvas;
  canvas.points.assign(mesh.points.begin(), mesh.points.begin() + std::ptrdiff_t(count));
  canvas.normals.assign(count, {});
  for (const auto& q : mesh.quads) {
    if (q[0] >= count) continue;
    const Vec3 n = cross(mesh.points[q[2]] - mesh.points[q[0]], mesh.points[q[3]] - mesh.points[q[1]]);
    for (const Index v : q) canvas.normals[v] += n;
  }
  for (Vec3& n : canvas.normals) n = unit(n);
  canvas.lower.assign(jaw_weight.begin(), jaw_weight.begin() + std::ptrdiff_t(count));
  canvas.lid_hold.assign(count, 0);
  for (const auto& lids : mesh.lids)
    for (int ring = 0; ring < kLidRings; ++ring)
      for (const Index v : lids[ring]) canvas.lid_hold[v] = kLidFollow[ring];
  canvas.lips.assign(count, 0);
  for (int ring = kLipBorder; ring < kMouthRings; ++ring)
    for (const Index v : mesh.mouth[ring]) canvas.lips[v] = ring == kLipBorder ? 0.5f : 1.0f;
  return canvas;
}

Delta paint(const Canvas& canvas, const std::vector<Stroke>& strokes) {
  std::vector<Vec3> moves(canvas.points.size());
  for (const Stroke& s : strokes)
    for (std::size_t v = 0; v < moves.size(); ++v) {
      const Vec3 d = canvas.points[v] - s.centre;
      const Vec3 q{d.x / s.radius.x, d.y / s.radius.y, d.z / s.radius.z};
      const float r = 1 - dot(q, q);
      if (r <= 0) continue;
      float weight = r * r * (1 - canvas.lid_hold[v]);
      if (s.on == On::upper) weight *= 1 - canvas.lower[v];
      if (s.on == On::lower) weight *= canvas.lower[v];
      if (s.on == On::face) weight *= 1 - canvas.lips[v];
      moves[v] += (s.move + canvas.normals[v] * s.push + scale(s.grow, d)) * weight;
    }
  return sparse(moves);
}

Delta sparse(const std::vector<Vec3>& moves) {
  constexpr float kSmallest = 1e-4f;  // cm
  Delta delta;
  for (std::size_t v = 0; v < moves.size(); ++v)
    if (dot(moves[v], moves[v]) > kSmallest * kSmallest) {
      delta.vertices.push_back(Index(v));
      delta.moves.push_back(moves[v]);
    }
  return delta;
}

}  // namespace sample_face
