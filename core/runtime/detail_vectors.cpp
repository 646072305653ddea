#include "runtime/detail_vectors.h"

#include <algorithm>

#include "base/vector3.h"

namespace fb::runtime {
namespace {

// A unit vector, or null where those of the corners are or cancel out: one that is neither would turn all at once where
// a blend comes near it.
Vector3 interpolated(const float* vectors, const DetailPoint& point) {
  const auto corner = [&](std::size_t c) { return vector_at(vectors, point.corners[c]) * point.weights[c]; };
  return normalized((corner(0) + corner(1)) + corner(2));
}

// The unit vector of this direction, perpendicular to a normal that is not null; null where there is none.
void write_unit(Vector3 v, const float* normal, float* to) {
  if (normal) v = v - vector_at(normal, 0) * dot(v, vector_at(normal, 0));
  const Vector3 unit = normalized(v);
  to[0] = unit.x;
  to[1] = unit.y;
  to[2] = unit.z;
}

}  // namespace

void blend_vectors(const DetailLayout& layout, const DetailChoice& choice, const DetailVectors& from, bool all,
                   const float* normals, const Spread& spread, float* to) {
  const std::size_t last_level = layout.levels.back().vertices, surface = last_level + layout.points.size();
  const std::size_t of_level = choice.level ? choice.level->vertices : surface;
  const std::size_t of_both = choice.next ? choice.next->vertices : of_level;
  const auto normal_of = [&](std::size_t i) { return normals ? normals + 3 * i : nullptr; };
  spread.run_ranges(of_level, 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float* const own = from.of_level + 3 * std::size_t(from.order.empty() ? i : from.order[i]);
      if (!choice.next) {
        std::copy_n(own, 3, to + 3 * i);
        continue;
      }
      const Vector3 next =
          i < of_both ? vector_at(from.of_next, i) : interpolated(from.of_next, layout.points[i - last_level]);
      write_unit(mix(vector_at(own, 0), next, choice.share), normal_of(i), to + 3 * i);
    }
  });
  // Their corners are vertices before them.
  for (std::size_t i = of_level; all && i < surface; ++i)
    write_unit(interpolated(to, layout.points[i - last_level]), normal_of(i), to + 3 * i);
}

}  // namespace fb::runtime
