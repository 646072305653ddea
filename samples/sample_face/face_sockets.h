// Places on the face where things hang: a hat, glasses, earrings.
#pragma once

#include <string>
#include <vector>

#include "face_mesh.h"

namespace sample_face {

struct FaceSocket {
  std::string name;
  std::vector<Index> vertices;  // that it moves with
  Vec3 origin;                  // at rest; its axes are those of space
};

std::vector<FaceSocket> face_sockets(const FaceMesh& mesh);

}  // namespace sample_face
