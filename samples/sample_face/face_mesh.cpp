#include "face_mesh.h"

namespace sample_face {

Index FaceMesh::add(Vec3 p) {
  points.push_back(p);
  return Index(points.size() - 1);
}

void FaceMesh::bridge(const Ring& outer, const Ring& inner) {
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const std::size_t next = (i + 1) % outer.size();
    quads.push_back({outer[i], outer[next], inner[next], inner[i]});
  }
}

Ring FaceMesh::cap(const Ring& ring, int a, int b) {
  const auto on_ring = [&](int i, int j) {
    if (j == 0) return ring[i];
    if (i == a) return ring[a + j];
    if (j == b) return ring[a + b + (a - i)];
    return ring[(2 * a + b + (b - j)) % ring.size()];
  };
  const auto at = [&](int i, int j) { return points[on_ring(i, j)]; };
  Ring grid((a + 1) * (b + 1));
  for (int j = 0; j <= b; ++j)
    for (int i = 0; i <= a; ++i) {
      Index& vertex = grid[j * (a + 1) + i];
      if (i == 0 || j == 0 || i == a || j == b) {
        vertex = on_ring(i, j);
        continue;
      }
      const float s = float(i) / float(a), t = float(j) / float(b);  // Coons patch
      const Vec3 corners = mix(mix(at(0, 0), at(a, 0), s), mix(at(0, b), at(a, b), s), t);
      vertex = add(mix(at(0, j), at(a, j), s) + mix(at(i, 0), at(i, b), t) - corners);
    }
  for (int j = 0; j < b; ++j)
    for (int i = 0; i < a; ++i) {
      const Index* v = &grid[j * (a + 1) + i];
      quads.push_back({v[0], v[1], v[a + 2], v[a + 1]});
    }
  return grid;
}

FaceMesh build_face_mesh() {
  FaceMesh mesh;
  add_head(mesh);
  mesh.skin = {0, Index(mesh.points.size())};
  add_eye(mesh, 0);
  add_eye(mesh, 1);
  add_teeth(mesh, true);
  add_teeth(mesh, false);
  add_tongue(mesh);
  return mesh;
}

}  // namespace sample_face
