#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "archive/proof.h"
#include "model/face_model.h"

namespace fb {

struct VerifyReport {
  std::uint64_t bytes = 0;
  std::size_t poses = 0, vertices = 0;  // compared
  double worst = 0;                     // largest distance from what was archived, over the diagonal
};

// A deviation from the archived positions that is still arithmetic, not damage: over the diagonal.
inline constexpr double verify_tolerance = 1e-6;

// Evaluates some poses of the model as a reader of its archive will: rest, every control at its ends, and seeded dense ones.
Proof make_proof(const FaceModel& as_packed, std::uint64_t seed);

// Reads an archive whole, evaluates the poses stored in it and compares. Fails with the reader's error if it is damaged, with
// corrupt if a vertex lies further off than verify_tolerance.
VerifyReport verify_archive(std::span<const std::byte> archive);

}  // namespace fb
