// Reads an .fbk archive into a packed model. FORMAT.md beside this file is the normative description.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "archive/container/container_reader.h"
#include "archive/proof.h"
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "model/packed_model.h"

namespace fb::archive {

struct ReadLimits {
  // Upper bound on the memory that reading takes at any time: decompressed sections, temporaries, and what was read.
  std::uint64_t max_model_bytes = std::uint64_t(4) << 30;
  std::uint64_t max_name_bytes = std::uint64_t(16) << 20;  // of all names and texts together
  std::uint64_t max_vertices = std::uint64_t(4) << 20;
  std::uint64_t max_polygons = std::uint64_t(8) << 20;
  std::uint64_t max_features = std::uint64_t(1) << 20;
};

// Parts of an archive that can be read by themselves. The definition is always read.
enum class Parts : std::uint32_t {
  definition = 0,  // names, units, controls, the number of vertices
  mesh = 1,        // polygons, rest points, texture coordinates, and all of the character
  behaviour = 2,   // network, basis and expected errors
  text = 4,        // provenance, licence, certificate
  proof = 8,
  all = 15
};
constexpr bool has(Parts parts, Parts part) {
  return (static_cast<std::uint32_t>(parts) & static_cast<std::uint32_t>(part)) != 0;
}
constexpr Parts operator|(Parts a, Parts b) {
  return static_cast<Parts>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}

struct Archive {
  PackedModel model;
  std::uint32_t vertices = 0;  // of the surface, known even if its points were not read
  Proof proof;
  ArchiveText text;
  std::uint32_t format_version = 0;  // major * 1000 + minor
  std::vector<SectionInfo> sections;
  std::vector<std::string> notes;  // sentences about harmless oddities, such as a skipped unknown section
};

// Reads an archive, or some parts of it; members of other parts stay empty. The bytes are untrusted and may be a file
// mapped read-only: every size is checked before use, all checksums are verified, and a model read with mesh and
// behaviour has passed check(PackedModel). Fails with
//   not_an_archive  no .fbk signature, or no bytes
//   unsupported     another format version, an unknown required section, codec, flag or kind
//   corrupt         truncated, damaged, trailing bytes, inconsistent contents
//   limit           more memory needed than `limits` allow, or more of something
// and a message that names section and byte offset. Thread-safe; keeps no reference to `bytes`.
Archive read_archive(std::span<const std::byte> bytes, const ReadLimits& limits = {}, Parts parts = Parts::all);
// The same with memory of a budget in place of max_model_bytes, and the values of the basis decoded in parallel. The
// archive stays charged to the budget for good.
Archive read_archive(std::span<const std::byte> bytes, const ReadLimits& limits, Parts parts, MemoryBudget& budget,
                     const Parallel& parallel = {1});

// The newest format version this library reads and writes, major * 1000 + minor.
std::uint32_t archive_format_version();
// That of an archive whose header was read.
std::uint32_t format_version_of(std::span<const std::byte> archive);

}  // namespace fb::archive
