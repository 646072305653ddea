#include "production/lip_cage.h"

namespace rigs::production {
namespace {

constexpr Vec low{-4.4f, -8.0f, 3.5f}, high{4.4f, -2.6f, 11.5f};

// Where x lies between the planes of a lattice: 0 at the first of them, n - 1 at the last.
float lattice_coordinate(float x, float from, float to, int n) {
  return std::clamp((x - from) / (to - from), 0.0f, 1.0f) * static_cast<float>(n - 1);
}

}  // namespace

LipCage::LipCage(const FaceMesh& mesh, const std::vector<FaceBone>& bones) {
  for (int i = 0; i < size; ++i) {
    const auto along = [&](float from, float to, int at, int n) {
      return std::lerp(from, to, static_cast<float>(at) / static_cast<float>(n - 1));
    };
    const Vec point{along(low.x, high.x, i % nx, nx), along(low.y, high.y, i / nx % ny, ny),
                    along(low.z, high.z, i / (nx * ny), nz)};
    rest_[static_cast<std::size_t>(i)] = point;
    for (int cage = 0; cage < 2; ++cage) {
      std::vector<Pull>& pulls = pulls_[static_cast<std::size_t>(cage * size + i)];
      const std::uint32_t part = part_bit(cage == 0 ? Part::upper_lip : Part::lower_lip);
      float sum = 0.02f;  // the skull
      for (std::size_t b = 0; b < bones.size(); ++b) {
        if (!(bones[b].parts & part)) continue;
        const Vec off = point - bones[b].head;
        const float weight = std::exp(-0.5f * (off.x * off.x + off.y * off.y + 0.15f * off.z * off.z) / 1.4f);
        if (weight < 0.01f) continue;
        pulls.push_back({b, weight});
        sum += weight;
      }
      for (Pull& pull : pulls) pull.weight /= sum;
    }
  }
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (mesh.parts[v] != Part::tongue) bind(v, mesh.points[v], mesh.parts[v]);
}

void LipCage::bind(std::size_t vertex, Vec point, Part part) {
  const Vec off = point - mouth_centre;
  const float share = 0.6f * bump(std::hypot(off.x / 4.2f, off.y / 2.5f), 1);
  if (share < 1e-3f) return;
  Bound& bound = bound_.emplace_back();
  bound.vertex = vertex;
  bound.rest = point;
  bound.share = share;
  bound.upper = part == Part::upper_lip ? 1 : part == Part::lower_lip ? 0 : smoothstep(-1, 1, off.y);
  const float x = lattice_coordinate(point.x, low.x, high.x, nx), y = lattice_coordinate(point.y, low.y, high.y, ny),
              z = lattice_coordinate(point.z, low.z, high.z, nz);
  const int i = std::min(static_cast<int>(x), nx - 2), j = std::min(static_cast<int>(y), ny - 2),
            k = std::min(static_cast<int>(z), nz - 2);
  const float u = x - static_cast<float>(i), v = y - static_cast<float>(j), w = z - static_cast<float>(k);
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const auto at = static_cast<std::size_t>(corner);
    bound.corners[at] = i + dx + nx * (j + dy + ny * (k + dz));
    bound.weights[at] = (dx ? u : 1 - u) * (dy ? v : 1 - v) * (dz ? w : 1 - w);
  }
}

LipCage::Lattice LipCage::posed(int cage, const std::vector<Motion>& motions) const {
  Lattice points;
  for (std::size_t i = 0; i < size; ++i) {
    Vec moved;
    for (const Pull& pull : pulls_[static_cast<std::size_t>(cage) * size + i])
      moved += (motions[pull.bone](rest_[i]) - rest_[i]) * pull.weight;
    const Vec p = rest_[i] + moved;
    const float x = p.x / teeth_half_width, z = (p.z - teeth_centre_z) / teeth_depth;
    const float far = std::max(0.2f, std::hypot(x, z));
    const float push = i >= size / nz ? 0.6f * soft_ramp(1.05f - far, 0.15f) / far : 0;  // the outer side only
    points[i] = {p.x * (1 + push), p.y, p.z + (p.z - teeth_centre_z) * push};
  }
  // Neighbours further apart than 1.35 times their distance at rest are drawn together.
  Lattice drawn = points;
  for (std::size_t i = 0; i + 1 < size; ++i) {
    if (i % nx == nx - 1) continue;
    const Vec apart = points[i + 1] - points[i];
    const float is = length(apart), most = 1.35f * (rest_[i + 1].x - rest_[i].x);
    const Vec back = apart * (0.4f * soft_ramp(is - most, 0.25f) / is);
    drawn[i] += back;
    drawn[i + 1] += back * -1;
  }
  return drawn;
}

void LipCage::apply(const std::vector<Motion>& motions, Vec* points) const {
  const Lattice upper = posed(0, motions), lower = posed(1, motions);
  for (const Bound& bound : bound_) {
    Vec moved;
    for (std::size_t k = 0; k < bound.corners.size(); ++k) {
      const auto corner = static_cast<std::size_t>(bound.corners[k]);
      moved += (mix(lower[corner], upper[corner], bound.upper) - rest_[corner]) * bound.weights[k];
    }
    points[bound.vertex] = mix(points[bound.vertex], bound.rest + moved, bound.share);
  }
}

}  // namespace rigs::production
