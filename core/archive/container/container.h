// The outer shell of an .fbk: header, section table, checksums. Knows nothing of what sections hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "archive/container/byte_reader.h"
#include "archive/container/layout.h"

namespace fb::archive {

// One row of the section table.
struct SectionInfo {
  std::string name;
  std::uint64_t offset = 0, stored_bytes = 0, raw_bytes = 0;
  bool required = false;
};

struct StoredSection {
  SectionInfo info;
  Codec codec = Codec::none;
  std::span<const std::byte> stored;

  // "section "basis" (byte 1234)"
  std::string where() const;
  // The contents, unpacked; the budget is charged.
  std::vector<std::byte> unpack(Budget& budget) const;
};

struct FormatVersion {
  std::uint16_t major = archive_major, minor = archive_minor;
};

// All sections, in file order, with every checksum verified and every byte of the file accounted for. Other major
// versions than that of `version` are refused; of major 0, other minor ones too.
std::vector<StoredSection> read_container(std::span<const std::byte> bytes, FormatVersion version = {});

const StoredSection* find_section(const std::vector<StoredSection>& sections, std::string_view name);

}  // namespace fb::archive
