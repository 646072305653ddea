#include "bake/pipeline/scaled_archive.h"

#include <utility>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "bake/rig/scaled_source.h"

namespace fb::bake {

std::vector<std::byte> in_units_of_source(std::span<const std::byte> archive, int exponent, std::uint64_t seed) {
  archive::Archive face = archive::read_archive(archive);
  const PackedModel model = scaled(std::move(face.model), -exponent);
  return archive::write_archive(model, make_proof(model, seed), face.text);
}

}  // namespace fb::bake
