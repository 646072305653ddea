#include "model/mesh_scale.h"

#include <cmath>

namespace fb {

int scale_exponent(const Mesh& mesh) {
  constexpr int least = -10, largest = 20;  // of an ordinary diagonal
  const int exponent = std::ilogb(mesh.diagonal());
  return exponent >= least && exponent < largest ? 0 : -exponent;
}

}  // namespace fb
