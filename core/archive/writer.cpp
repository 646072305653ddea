#include "archive/writer.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "archive/section_writer.h"
#include "base/hash.h"

namespace fb {
namespace {

struct Packed {
  const char* name;
  bool required;
  Codec codec;
  std::uint64_t raw_bytes;
  std::vector<std::byte> stored;
};

// zstd where it saves more than a few bytes. Level 19 takes seconds on megabytes of weights and gains next to nothing
// there.
Packed pack(const char* name, bool required, std::vector<std::byte> raw) {
  std::vector<std::byte> zipped(ZSTD_compressBound(raw.size()));
  const int level = raw.size() < (1u << 20) ? 19 : 12;
  const std::size_t size = ZSTD_compress(zipped.data(), zipped.size(), raw.data(), raw.size(), level);
  if (ZSTD_isError(size)) fail(Status::internal, "section \"%s\": %s", name, ZSTD_getErrorName(size));
  if (size + 64 > raw.size()) return {name, required, Codec::none, raw.size(), std::move(raw)};
  zipped.resize(size);
  return {name, required, Codec::zstd, raw.size(), std::move(zipped)};
}

std::vector<std::byte> assemble(const std::vector<Packed>& sections) {
  const std::size_t table_end = header_bytes + sections.size() * table_row_bytes;
  std::uint64_t offset = table_end + checksum_bytes;
  std::uint64_t size = offset + checksum_bytes;
  for (const Packed& section : sections) size += section.stored.size();

  ByteWriter out;
  out.bytes.reserve(size);
  out.raw(std::as_bytes(std::span(archive_magic)));
  out.number(archive_major);
  out.number(archive_minor);
  out.number(static_cast<std::uint32_t>(sections.size()));
  out.number(size);
  for (const Packed& section : sections) {
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
  for (const Packed& section : sections) out.raw(section.stored);
  out.number(hash64(out.bytes));
  return std::move(out.bytes);
}

}  // namespace

std::vector<std::byte> write_archive(const PackedModel& model, const Proof& proof) {
  check(model);
  if (model.provenance.find('\0') != std::string::npos) fail(Status::bad_data, "the provenance holds a zero byte");
  std::vector<Packed> sections;
  sections.push_back(pack(section::definition, true, write_definition(model).bytes));
  sections.push_back(pack(section::polygons, true, write_polygons(model.rest).bytes));
  sections.push_back(pack(section::geometry, true, write_geometry(model.rest).bytes));
  sections.push_back(pack(section::network, true, write_network(model).bytes));
  sections.push_back(pack(section::basis, true, write_basis(model).bytes));
  if (!model.provenance.empty()) {
    const auto text = std::as_bytes(std::span(model.provenance));
    sections.push_back(pack(section::provenance, false, {text.begin(), text.end()}));
  }
  if (!proof.controls.empty()) sections.push_back(pack(section::proof, false, write_proof(proof, model).bytes));
  return assemble(sections);
}

}  // namespace fb
