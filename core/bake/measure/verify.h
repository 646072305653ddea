// Proof that an archive still poses as it did when it was made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "archive/proof.h"
#include "bake/measure/errors.h"
#include "base/parallel.h"
#include "model/face_model.h"
#include "model/packed_model.h"

namespace fb::bake {

struct VerifyReport {
  std::uint64_t bytes = 0;
  std::size_t poses = 0, vertices = 0;  // compared
};

// What the model gives for a few poses: rest, both ends of all controls, seeded dense ones.
archive::Proof make_proof(const PackedModel& model, std::uint64_t seed);

// Reads an archive whole, evaluates the poses of its proof and compares every bit. Fails with the reader's error if it
// is damaged, with corrupt at the first pose that differs, naming the coordinate where that is known.
VerifyReport verify_archive(std::span<const std::byte> archive);

// How far a packed face is from the one of floats it was made of, over these poses (poses x controls).
Errors packing_errors(const FaceModel& model, const PackedModel& packed, std::span<const float> controls,
                      const Parallel& parallel);

// The same of two packed faces with the same controls and vertices. Keeps all positions of one of them meanwhile.
Errors packing_errors(const PackedModel& model, const PackedModel& repacked, std::span<const float> controls);

}  // namespace fb::bake
