// Takes an archive apart so that a test can change anything in it, and assembles it with valid checksums.
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "archive/container/container_reader.h"
#include "base/hash.h"

namespace fb {
using namespace archive;

using Bytes = std::vector<std::byte>;

inline bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

template <class T>
void patch(Bytes& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <class T>
void append(Bytes& bytes, T value) {
  bytes.resize(bytes.size() + sizeof value);
  patch(bytes, bytes.size() - sizeof value, value);
}

// Sets to infinity the first of the floats stored in planes at byte `at`, after their count.
inline void patch_infinity(Bytes& bytes, std::size_t at) {
  std::uint32_t count;
  std::memcpy(&count, bytes.data() + at - sizeof count, sizeof count);
  const unsigned char infinity[4] = {0, 0, 0x80, 0x7f};
  for (std::size_t plane = 0; plane < 4; ++plane) patch(bytes, at + plane * count, infinity[plane]);
}

// The position in the file of the field at `offset` in row `row` of the section table.
inline std::size_t table_at(std::size_t row, std::size_t offset) {
  return header_bytes + row * table_row_bytes + offset;
}

// Updates table checksum and file checksum after a change to header, table or sections.
inline Bytes sealed(Bytes bytes) {
  std::uint32_t count;
  std::memcpy(&count, bytes.data() + 12, sizeof count);
  const std::size_t table_end = table_at(count, 0);
  patch(bytes, table_end, hash64(std::span(bytes).first(table_end)));
  patch(bytes, bytes.size() - 8, hash64(std::span(bytes).first(bytes.size() - 8)));
  return bytes;
}

struct ArchiveEditor {
  struct Section {
    std::string name;
    std::uint32_t flags = 0, codec = 0;
    std::uint64_t raw_bytes = 0;
    Bytes stored;

    // Replaces the contents, uncompressed.
    void set(Bytes contents) {
      codec = 0;
      raw_bytes = contents.size();
      stored = std::move(contents);
    }
  };
  std::uint16_t major = archive_major, minor = 0;
  std::vector<Section> sections;

  // Opens an archive and decompresses all its sections, to at most `limit` bytes.
  explicit ArchiveEditor(std::span<const std::byte> bytes, std::uint64_t limit = UINT64_MAX) {
    MemoryBudget budget(limit);
    const auto parts = read_container(bytes);
    minor = std::to_integer<std::uint16_t>(bytes[10]);
    for (const StoredSection& section : parts) {
      sections.push_back({section.info.name, section.info.required ? section_required : 0u, 0, 0, {}});
      std::pmr::vector<std::byte> unpacked(&budget);
      const auto contents = section.contents(budget, unpacked);
      sections.back().set({contents.begin(), contents.end()});
    }
  }

  Section& operator[](const std::string& name) {
    for (Section& section : sections)
      if (section.name == name) return section;
    sections.push_back({name, 0, 0, 0, {}});
    return sections.back();
  }

  Bytes bytes() const {
    Bytes out;
    for (const unsigned char c : archive_signature) append(out, c);
    append(out, major);
    append(out, minor);
    append(out, static_cast<std::uint32_t>(sections.size()));
    std::uint64_t offset = table_at(sections.size(), 0) + checksum_bytes, size = offset + checksum_bytes;
    for (const Section& section : sections) size += section.stored.size();
    append(out, size);
    for (const Section& section : sections) {
      char name[section_name_bytes] = {};
      std::memcpy(name, section.name.data(), std::min(section.name.size(), sizeof name));
      for (const char c : name) append(out, c);
      append(out, section.flags);
      append(out, section.codec);
      append(out, offset);
      append(out, std::uint64_t(section.stored.size()));
      append(out, section.raw_bytes);
      append(out, hash64(section.stored));
      offset += section.stored.size();
    }
    append(out, std::uint64_t(0));
    for (const Section& section : sections) out.insert(out.end(), section.stored.begin(), section.stored.end());
    append(out, std::uint64_t(0));
    return sealed(std::move(out));
  }
};

// Coded symbols of which this table always decodes to this symbol, and the others to 0, with `words` words of 0 in
// stream 0 of the first part.
inline Bytes constant_symbols(std::size_t tables, std::size_t parts, std::size_t table, std::uint8_t symbol,
                              std::uint32_t words = 0) {
  Bytes out;
  append(out, static_cast<std::uint8_t>(tables));
  for (std::size_t t = 0; t < tables; ++t) {
    append(out, std::uint16_t(t == table));
    if (t != table) continue;
    append(out, symbol);
    append(out, std::uint8_t(0x80));
    append(out, std::uint8_t(8));
  }
  for (std::size_t part = 0; part < parts; ++part) {
    for (int stream = 0; stream < 4; ++stream) append(out, part == 0 && stream == 0 ? words : 0u);
    for (int stream = 0; stream < 4; ++stream) append(out, std::uint32_t(65536));
  }
  for (std::uint32_t word = 0; word < words; ++word) append(out, std::uint16_t(0));
  return out;
}

}  // namespace fb
