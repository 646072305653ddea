// Compresses sections and assembles them into the bytes of an .fbk, the counterpart of container_reader.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "archive/container/container_layout.h"

namespace fb::archive {

struct WrittenSection {
  const char* name;
  bool required;
  Codec codec;
  std::uint64_t raw_bytes;
  std::vector<std::byte> stored;
};

// Deflates the contents if that saves more than 64 bytes.
WrittenSection compressed_section(const char* name, bool required, std::vector<std::byte> raw);
// For contents that are entropy-coded already.
WrittenSection uncompressed_section(const char* name, bool required, std::vector<std::byte> raw);

// Header, section table, sections in this order, and all checksums. minor: of the lowest version that has everything
// that they use.
std::vector<std::byte> assemble_container(const std::vector<WrittenSection>& sections, std::uint16_t minor = 0);

}  // namespace fb::archive
