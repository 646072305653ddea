#include "model/mesh_scale.h"

#include <cmath>

namespace fb {

int scale_exponent(const Mesh& mesh) {
  constexpr int least = -10, largest = 20;  // of an ordinary diagonal
  const double diagonal = mesh.diagonal();
  if (diagonal == 0) return 0;  // of a level of detail that has one vertex
  const int exponent = std::ilogb(diagonal);
  return exponent >= least && exponent < largest ? 0 : -exponent;
}

}  // namespace fb
