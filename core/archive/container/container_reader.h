// The container of an .fbk: header, section table, checksums and compression, but not the contents of sections.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "archive/container/byte_reader.h"
#include "archive/container/container_layout.h"

namespace fb::archive {

// One row of the section table.
struct SectionInfo {
  std::string name;
  std::uint64_t offset = 0, stored_bytes = 0, raw_bytes = 0;  // raw: decompressed
  bool required = false;
};

struct StoredSection {
  SectionInfo info;
  Codec codec = Codec::none;
  std::span<const std::byte> stored;  // a view of the archive's bytes

  // For messages: section "basis" (byte 1234)
  std::string where() const;
  // The contents: `stored`, or decompressed into `unpacked`, an empty vector with memory of the budget. Fails with
  // `corrupt`, `unsupported` or `limit`.
  std::span<const std::byte> contents(MemoryBudget& budget, std::pmr::vector<std::byte>& unpacked) const;
};

// All sections in file order. Verifies every checksum and accounts for every byte of the file. Refuses other major
// versions as unsupported.
std::vector<StoredSection> read_container(std::span<const std::byte> bytes);

// The size of the whole archive, as its header says; `beginning`: its first header_bytes bytes. Fails as
// read_container() does with what is no archive, or one of another version.
std::uint64_t archive_size(std::span<const std::byte> beginning);

// Null if there is no such section.
const StoredSection* find_section(const std::vector<StoredSection>& sections, std::string_view name);
// Fails with `corrupt` if there is no such section.
const StoredSection& require_section(const std::vector<StoredSection>& sections, const char* name);

}  // namespace fb::archive
