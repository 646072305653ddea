#include "archive/container/container_writer.h"

#include <zlib.h>

#include <cstring>

#include "archive/container/byte_writer.h"
#include "base/hash.h"

namespace fb::archive {

WrittenSection compressed_section(const char* name, bool required, std::vector<std::byte> raw) {
  uLongf size = compressBound(raw.size());
  std::vector<std::byte> deflated(size);
  if (compress2(reinterpret_cast<Bytef*>(deflated.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
                raw.size(), Z_BEST_COMPRESSION) != Z_OK)
    fail(Status::out_of_memory, "no memory to compress section \"%s\"", name);
  if (size + 64 > raw.size()) return uncompressed_section(name, required, std::move(raw));
  deflated.resize(size);
  return {name, required, Codec::deflate, raw.size(), std::move(deflated)};
}

WrittenSection uncompressed_section(const char* name, bool required, std::vector<std::byte> raw) {
  const std::uint64_t size = raw.size();
  return {name, required, Codec::none, size, std::move(raw)};
}

std::vector<std::byte> assemble_container(const std::vector<WrittenSection>& sections, std::uint16_t minor) {
  const std::size_t table_end = header_bytes + sections.size() * table_row_bytes;
  std::uint64_t offset = table_end + checksum_bytes;
  std::uint64_t size = offset + checksum_bytes;
  for (const WrittenSection& section : sections) size += section.stored.size();

  ByteWriter out;
  out.bytes.reserve(size);
  out.raw(std::as_bytes(std::span(archive_signature)));
  out.number(archive_major);
  out.number(minor);
  out.number(static_cast<std::uint32_t>(sections.size()));
  out.number(size);
  for (const WrittenSection& section : sections) {
    char name[section_name_bytes] = {};
    std::memcpy(name, section.name, std::strlen(section.name));
    out.raw(std::as_bytes(std::span(name)));
    out.number(section.required ? section_required : 0u);
    out.number(static_cast<std::uint32_t>(section.codec));
    out.number(offset);
    out.number(std::uint64_t(section.stored.size()));
    out.number(section.raw_bytes);
    out.number(hash64(section.stored));
    offset += section.stored.size();
  }
  out.number(hash64(out.bytes));
  for (const WrittenSection& section : sections) out.raw(section.stored);
  out.number(hash64(out.bytes));
  return std::move(out.bytes);
}

}  // namespace fb::archive
