#include "export/morph_targets.h"

#include <algorithm>
#include <cmath>

#include "export/glb_buffer.h"

namespace fb::tool {

void MorphTargets::add(std::span<const float> displacement) {
  displacements.insert(displacements.end(), displacement.begin(), displacement.end());
  ++count;
}

std::size_t MorphTargets::stored_bytes() const {
  std::size_t bytes = weights.size() * sizeof(float);
  for (std::size_t t = 0; t < count; ++t) {
    const std::span<const float> moves = target(t);
    std::size_t moved = 0;
    for (std::size_t i = 0; i < moves.size(); i += 3) moved += moves[i] != 0 || moves[i + 1] != 0 || moves[i + 2] != 0;
    // Normals take as much again. A sparse vector has its index beside it.
    bytes += 2 * sizeof(float) * (is_sparse(moved, moves.size() / 3) ? 4 * moved : moves.size());
  }
  return bytes;
}

double MorphError::rms() const {
  return points ? std::sqrt(squares / double(points)) : 0;
}

void MorphError::add(const MorphError& other) {
  largest = std::max(largest, other.largest);
  squares += other.squares;
  points += other.points;
}

MorphError morph_error(const MorphTargets& morph, std::span<const float> weights, std::span<const float> displacements,
                       std::size_t frames) {
  MorphError error;
  const std::size_t size = displacements.size() / frames;
  std::vector<float> sum(size);
  for (std::size_t f = 0; f < frames; ++f) {
    std::fill(sum.begin(), sum.end(), 0.0f);
    for (std::size_t t = 0; t < morph.count; ++t) {
      const float weight = weights[f * morph.count + t];
      if (weight == 0) continue;
      const float* target = morph.target(t).data();
      for (std::size_t i = 0; i < size; ++i) sum[i] += weight * target[i];
    }
    const float* expected = &displacements[f * size];
    for (std::size_t i = 0; i < size; i += 3) {
      const double x = sum[i] - expected[i], y = sum[i + 1] - expected[i + 1], z = sum[i + 2] - expected[i + 2];
      const double square = x * x + y * y + z * z;
      error.squares += square;
      error.largest = std::max(error.largest, std::sqrt(square));
    }
  }
  error.points = frames * (size / 3);
  return error;
}

}  // namespace fb::tool
