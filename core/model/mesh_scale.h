#pragma once

#include "model/mesh.h"

namespace fb {

// The power of two by which a mesh is scaled before squares of distances or products of three of them are computed as
// floats: 0 while its diagonal is 2^-10 to 2^20, which is what faces in any usual unit have; else that which makes the
// diagonal 1 to 2.
int scale_exponent(const Mesh& mesh);

}  // namespace fb
