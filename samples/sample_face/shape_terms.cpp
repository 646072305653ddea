#include "shape_terms.h"

namespace sample_face {

float Term::weight(const float* controls) const {
  const float first = controls[drivers[0].control];
  if (law == Law::linear) return first;
  float w = std::max(0.0f, drivers[0].sign * first);
  if (law == Law::between) return std::max(0.0f, 1 - std::fabs(2 * w - 1));
  for (int i = 1; i < driver_count; ++i) {
    const float a = std::max(0.0f, drivers[i].sign * controls[drivers[i].control]);
    w = law == Law::product ? w * a : std::min(w, a);
  }
  return w;
}

}  // namespace sample_face
