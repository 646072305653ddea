#include "solve/solve_target.h"

namespace fb::tool {

void SolveTarget::find(std::size_t frame, std::vector<float>& raw, std::vector<float>& positions) const {
  read(frame, raw);
  const std::size_t count = face_points.empty() ? raw.size() / 3 : face_points.size();
  positions.resize(3 * count);
  for (std::size_t p = 0; p < count; ++p) {
    const Vector3 at =
        target_points.empty() ? Vector3{raw[3 * p], raw[3 * p + 1], raw[3 * p + 2]} : target_points[p].at(raw);
    const Vector3 moved = to_face(at);
    positions[3 * p] = moved.x;
    positions[3 * p + 1] = moved.y;
    positions[3 * p + 2] = moved.z;
  }
}

void SolveTarget::set_offsets(std::size_t neutral, std::span<const float> rest) {
  std::vector<float> raw;
  find(neutral, raw, offsets);
  for (std::size_t p = 0; p < offsets.size() / 3; ++p) {
    const Vector3 at =
        face_points.empty() ? Vector3{rest[3 * p], rest[3 * p + 1], rest[3 * p + 2]} : face_points[p].at(rest);
    const float own[3] = {at.x, at.y, at.z};
    for (std::size_t a = 0; a < 3; ++a) {
      float& offset = offsets[3 * p + a];
      offset = offset == offset ? offset - own[a] : 0;  // one that is not seen then has none
    }
  }
}

}  // namespace fb::tool
