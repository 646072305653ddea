// What an archive says of its own errors: see FORMAT.md, "certificate".
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bake/measure/evaluate.h"
#include "bake/rig/pose_set.h"

namespace fb::bake {

// A JSON object. `independent` and its split: with Detail::quality, on poses that were not trained on; absent where
// there are none. `quantisation`: see Baked::quantisation.
std::string certificate(const Errors& dependency, const std::optional<EvalReport>& independent, Split split,
                        const Errors& quantisation);

// Adds to a certificate (whatever text it is) by how much the face was rounded further since. What several roundings
// moved is added up.
void note_repacking(std::string& certificate, const Errors& moved);

// XXH64 of what a face is trained on: of the positions of each pose in order (little-endian floats, in the source's
// units), seeded with the hash before, from 0; then likewise of all controls.
std::uint64_t training_hash(const PoseSet& poses);

}  // namespace fb::bake
