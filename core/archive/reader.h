// From the bytes of an .fbk to a face model. FORMAT.md beside this file is the normative description.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb {

struct ReadLimits {
  // What reading may allocate in total: unpacked sections and the model made of them.
  std::uint64_t max_model_bytes = std::uint64_t(4) << 30;
};

// One row of the section table.
struct SectionInfo {
  std::string name;
  std::uint64_t offset = 0, stored_bytes = 0, raw_bytes = 0;
  bool required = false;
};

struct Archive {
  PackedModel model;
  Proof proof;
  std::uint32_t format_version = 0;  // major * 1000 + minor
  std::vector<SectionInfo> sections;
  std::vector<std::string> notes;  // sentences about what was odd but harmless: an optional section that was skipped
};

// Reads a whole archive. The bytes may come from anyone: every size is checked before it is believed, all checksums are
// verified, and the model returned has passed check(PackedModel). Fails with
//   not_an_archive  something else altogether, or nothing
//   unsupported     another format version, an unknown required section, codec or kind of node
//   corrupt         truncated, damaged, trailing bytes, contents that contradict themselves
//   limit           would take more than `limits`
// and a message that names the section and the byte offset. Thread-safe; keeps no reference to `bytes`.
Archive read_archive(std::span<const std::byte> bytes, const ReadLimits& limits = {});

// The format version this library reads and writes, major * 1000 + minor.
std::uint32_t archive_format_version();

}  // namespace fb
