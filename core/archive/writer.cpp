#include "archive/writer.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "archive/section_writer.h"
#include "base/hash.h"

namespace fb::archive {
namespace {

struct Packed {
  const char* name;
  bool required;
  Codec codec;
  std::uint64_t raw_bytes;
  std::vector<std::byte> stored;
};

// Deflated where that saves more than a few bytes.
Packed pack(const char* name, bool required, std::vector<std::byte> raw) {
  uLongf size = compressBound(raw.size());
  std::vector<std::byte> zipped(size);
  if (compress2(reinterpret_cast<Bytef*>(zipped.data()), &size, reinterpret_cast<const Bytef*>(raw.data()), raw.size(),
                Z_BEST_COMPRESSION) != Z_OK)
    fail(Status::internal, "section \"%s\" cannot be deflated", name);
  if (size + 64 > raw.size()) return {name, required, Codec::none, raw.size(), std::move(raw)};
  zipped.resize(size);
  return {name, required, Codec::deflate, raw.size(), std::move(zipped)};
}

// What is entropy-coded already.
Packed as_it_is(const char* name, std::vector<std::byte> raw) {
  return {name, true, Codec::none, raw.size(), std::move(raw)};
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

std::vector<std::byte> write_archive(const PackedModel& model, const Proof& proof, const ArchiveText& text) {
  check(model);
  std::vector<Packed> sections;
  sections.push_back(pack(section::definition, true, write_definition(model).bytes));
  const auto [geometry, triangles] = write_geometry(model.rest);
  sections.push_back(pack(section::polygons, true, write_polygons(model.rest, triangles).bytes));
  sections.push_back(pack(section::geometry, true, geometry.bytes));
  sections.push_back(pack(section::network, true, write_network(model).bytes));
  sections.push_back(as_it_is(section::weights, write_weights(model).bytes));
  sections.push_back(pack(section::basis, true, write_basis(model).bytes));
  sections.push_back(as_it_is(section::basis_values, write_basis_values(model).bytes));
  const auto add_text = [&](const char* name, const std::string& words) {
    if (!words.empty()) sections.push_back(pack(name, false, write_text(words, name).bytes));
  };
  if (!model.rest.uvs.empty()) sections.push_back(pack(section::uvs, false, write_uvs(model.rest).bytes));
  add_text(section::provenance, model.provenance);
  add_text(section::licence, text.licence);
  add_text(section::certificate, text.certificate);
  if (!proof.hashes.empty()) sections.push_back(pack(section::proof, false, write_proof(proof, model).bytes));
  return assemble(sections);
}

}  // namespace fb::archive
