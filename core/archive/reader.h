// From the bytes of an .fbk to a face model. FORMAT.md beside this file is the normative description.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "archive/container/container.h"
#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb::archive {

struct ReadLimits {
  // What reading may allocate in total: unpacked sections and the model made of them.
  std::uint64_t max_model_bytes = std::uint64_t(4) << 30;
};

// What can be read by itself; the definition always is.
enum class Layers : std::uint32_t {
  definition = 0,  // names, units, controls, the number of vertices
  mesh = 1,        // polygons, rest points and texture coordinates
  behaviour = 2,   // network and basis
  text = 4,        // provenance, licence, certificate
  proof = 8,
  all = 15
};
constexpr bool has(Layers layers, Layers one) {
  return (static_cast<std::uint32_t>(layers) & static_cast<std::uint32_t>(one)) != 0;
}
constexpr Layers operator|(Layers a, Layers b) {
  return static_cast<Layers>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}

struct Archive {
  PackedModel model;
  std::uint32_t vertices = 0;  // of the rest mesh, whose points may not have been read
  Proof proof;
  ArchiveText text;
  std::uint32_t format_version = 0;  // major * 1000 + minor
  std::vector<SectionInfo> sections;
  std::vector<std::string> notes;  // sentences about what was odd but harmless: an optional section that was skipped
};

// Reads an archive, or some layers of it: what belongs to others stays empty. The bytes may come from anyone, and may
// be a file mapped read-only: every size is checked before it is believed, all checksums are verified, and a model read
// with mesh and behaviour has passed check(PackedModel). Fails with
//   not_an_archive  something else altogether, or nothing
//   unsupported     another format version, an unknown required section, codec or kind of node
//   corrupt         truncated, damaged, trailing bytes, contents that contradict themselves
//   limit           would take more than `limits`
// and a message that names the section and the byte offset. Thread-safe; keeps no reference to `bytes`.
Archive read_archive(std::span<const std::byte> bytes, const ReadLimits& limits = {}, Layers layers = Layers::all);

// The format version this library reads and writes, major * 1000 + minor.
std::uint32_t archive_format_version();

}  // namespace fb::archive
