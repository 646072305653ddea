// Verification: an archive evaluates to the same bits as when it was made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "archive/proof.h"
#include "archive/reader.h"
#include "bake/measure/errors.h"
#include "base/parallel.h"
#include "model/face_model.h"
#include "model/packed_model.h"

namespace fb::bake {

struct VerifyReport {
  std::uint64_t bytes = 0;
  std::size_t poses = 0, vertices = 0;  // compared
  std::string certificate;              // of the archive, "" if it has none
};

// Reference poses of a model and their positions: rest, all controls at their maximum, at their minimum, and seeded
// dense poses. The archive carries them (FORMAT.md, "proof").
archive::Proof make_proof(const PackedModel& model, std::uint64_t seed);

// The same of these poses: poses x controls, in control order.
archive::Proof prove_poses(const PackedModel& model, std::vector<float> controls);

// Reads all of an archive, evaluates its reference poses and compares every bit. Fails with the reader's error if it is
// damaged, with corrupt at the first pose that differs, naming the coordinate where that is known.
VerifyReport verify_archive(std::span<const std::byte> archive);
// The same of an archive that was read whole, of so many bytes.
VerifyReport verify_archive(const archive::Archive& read, std::uint64_t bytes);

// Writes an archive to a temporary file beside `path`, verifies what is on the disk and renames it. Whatever fails
// (writing, verification), an old file at `path` stays as it was.
void write_verified_archive(const std::filesystem::path& path, std::span<const std::byte> archive);

// Errors of a packed model against the float model it was made of, over these poses (poses x controls).
Errors quantisation_errors(const FaceModel& model, const PackedModel& packed, std::span<const float> controls,
                           const Parallel& parallel);

// Displacements of a repacked model from the packed one, with the same controls and vertices.
Errors quantisation_errors(const PackedModel& model, const PackedModel& repacked, std::span<const float> controls);

}  // namespace fb::bake
