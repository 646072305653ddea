// Where the surface of the face lies in its textures.
#pragma once

#include "uv_chart.h"

namespace sample_face {

// All of the mesh in one square from (0, 0) to (1, 1), nothing over anything else: the skin round the head, cut up the
// back of it; below it eyes, inside of the mouth, tongue and teeth.
FaceUvs lay_out(const FaceMesh& mesh);

}  // namespace sample_face
