// Proof that an archive still poses as it did when it was made.
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

// Distance from the archived positions, over the diagonal, that another compiler's arithmetic may cause.
inline constexpr double verify_tolerance = 1e-6;

// What the model gives for a few poses (rest, both ends of all controls, seeded dense ones) at evenly spaced vertices.
// Pass the model as a reader of its archive gets it.
Proof make_proof(const FaceModel& as_packed, std::uint64_t seed);

// Reads an archive whole, evaluates the poses of its proof and compares. Fails with the reader's error if it is
// damaged, with corrupt if a vertex lies further off than verify_tolerance.
VerifyReport verify_archive(std::span<const std::byte> archive);

// Largest distance of any vertex between two models of one face, over these poses (poses x controls) and over the
// diagonal: what packing changed.
double worst_difference(const FaceModel& a, const FaceModel& b, std::span<const float> controls);

}  // namespace fb
