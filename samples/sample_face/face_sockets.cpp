#include "face_sockets.h"

namespace sample_face {
namespace {

// A socket holds on to the vertices of the skin that are nearest to a few points round it.
struct Hold {
  const char* name;
  Vec3 origin;  // the nearest vertex of the skin is where the frame is
  std::vector<Vec3> points;
};

std::vector<Hold> holds() {
  std::vector<Hold> holds = {
      {"hat", {0, 11.5f, -1}, {{0, 10, 4}, {4, 10, -1}, {-4, 10, -1}, {0, 10, -6}}},
      {"glasses", {0, 0.3f, 8.8f}, {{0, 1.2f, 8.5f}, {0.8f, 0.3f, 8}, {-0.8f, 0.3f, 8}, {0, -0.8f, 9.2f}}},
      {"earring_L", {7, -3.9f, -0.7f}, {{7, -3.9f, -0.7f}, {6.9f, -3.3f, 0}, {7.4f, -3.3f, -1.2f}, {6.7f, -3, -0.6f}}}};
  Hold right = holds.back();
  right.name = "earring_R";
  right.origin = mirrored(right.origin);
  for (Vec3& p : right.points) p = mirrored(p);
  holds.push_back(right);
  return holds;
}

Index nearest(const FaceMesh& mesh, Vec3 p) {
  Index best = mesh.skin.first;
  for (Index v = mesh.skin.first; v < mesh.skin.first + mesh.skin.count; ++v)
    if (length(mesh.points[v] - p) < length(mesh.points[best] - p)) best = v;
  return best;
}

}  // namespace

std::vector<FaceSocket> face_sockets(const FaceMesh& mesh) {
  std::vector<FaceSocket> sockets;
  for (const Hold& hold : holds()) {
    FaceSocket& socket = sockets.emplace_back();
    socket.name = hold.name;
    socket.origin = mesh.points[nearest(mesh, hold.origin)];
    for (const Vec3 p : hold.points) socket.vertices.push_back(nearest(mesh, p));
  }
  return sockets;
}

}  // namespace sample_face
