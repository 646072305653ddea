#include <zlib.h>

#include <cstring>

#include "golden_edits.h"

namespace fb {
namespace {

// A zlib stream that needs a preset dictionary.
Bytes deflated_with_dictionary(const Bytes& contents) {
  Bytes packed(contents.size() + 64);
  z_stream stream{};
  deflateInit(&stream, 9);
  const auto* data = reinterpret_cast<const Bytef*>(contents.data());
  deflateSetDictionary(&stream, data, static_cast<uInt>(contents.size()));
  stream.next_in = const_cast<Bytef*>(data);
  stream.avail_in = static_cast<uInt>(contents.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

// A byte more at `at`, of no section: rows of the table from `row` on begin behind it.
Bytes with_byte_between(Bytes bytes, std::size_t at, std::size_t row, std::size_t rows) {
  const auto add_one = [&](std::size_t field) {
    std::uint64_t number = 0;
    std::memcpy(&number, bytes.data() + field, sizeof number);
    patch(bytes, field, number + 1);
  };
  add_one(16);
  for (; row < rows; ++row) add_one(table_at(row, 40));
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), std::byte(0));
  return sealed(bytes);
}

void write_rejected_rows(const RejectedWriter& out) {
  const Bytes whole = with_proof(smallest());
  const std::vector<StoredSection> sections = read_container(whole);
  const std::size_t rows = sections.size();
  out.write("corrupt-gap.fbk", with_byte_between(whole, sections[1].info.offset, 1, rows));
  out.write("corrupt-gap-at-end.fbk", with_byte_between(whole, whole.size() - checksum_bytes, rows, rows));
  Bytes other = whole;
  patch(other, table_at(rows - 1, 48), std::uint64_t(1) << 40);
  out.write("corrupt-section-long.fbk", sealed(other));
  (other = whole)[table_at(1, 64)] ^= std::byte(1);
  out.write("corrupt-section-checksum.fbk", sealed(other));
  (other = whole)[table_at(rows, 0)] ^= std::byte(1);
  patch(other, other.size() - checksum_bytes, hash64(std::span(other).first(other.size() - checksum_bytes)));
  out.write("corrupt-table-checksum.fbk", other);
  const auto named = [&](const char* file, const std::string& name) {
    out.write(file, edited([&](ArchiveEditor& archive) { archive[name].set({}); }, smallest()));
  };
  named("corrupt-section-name-empty.fbk", "");
  named("corrupt-section-name-space.fbk", "ha ir");
  named("corrupt-section-name-padding.fbk", std::string("hair\0x", 6));
  out.write("unsupported-flags-skipped.fbk",
            edited([](ArchiveEditor& archive) { archive["hair"].flags = 2; }, smallest()));
  for (const char* name : {"polygons", "geometry", "network", "weights", "basis", "basis-values"})
    out.write(format("corrupt-missing-%s.fbk", name).c_str(), without(name, smallest()));
}

void write_rejected_streams(const RejectedWriter& out) {
  const auto deflated = [&](const char* file, const std::function<void(ArchiveEditor::Section&)>& change) {
    out.write(file, edited([&](ArchiveEditor& archive) {
                deflate_section(archive["basis"]);
                change(archive["basis"]);
              }));
  };
  deflated("corrupt-stream-short.fbk", [](auto& section) { --section.raw_bytes; });
  deflated("corrupt-stream-cut.fbk", [](auto& section) { section.stored.pop_back(); });
  deflated("corrupt-stream-checksum.fbk", [](auto& section) { section.stored.back() ^= std::byte(1); });
  deflated("corrupt-stream-4-gib.fbk", [](auto& section) { section.raw_bytes += std::uint64_t(1) << 32; });
  out.write("corrupt-stream-dictionary.fbk", edited([](ArchiveEditor& archive) {
              archive["basis"].stored = deflated_with_dictionary(archive["basis"].stored);
              archive["basis"].codec = 1;
            }));
  out.write("corrupt-raw-size.fbk", edited([](ArchiveEditor& archive) { ++archive["basis"].raw_bytes; }));
}

}  // namespace

void write_rejected_containers(const RejectedWriter& out) {
  const Bytes whole = with_proof(tiny_packed_model());
  Bytes other = whole;
  out.write("not_an_archive-empty.fbk", {});
  out.write("not_an_archive-text.fbk", text("#!/bin/sh\necho an archive\n"));
  other.erase(other.begin() + 4);
  out.write("corrupt-line-ends.fbk", other);
  out.write("corrupt-cut-in-signature.fbk", Bytes(whole.begin(), whole.begin() + 3));
  out.write("corrupt-cut-in-header.fbk", Bytes(whole.begin(), whole.begin() + 20));
  out.write("corrupt-cut-in-table.fbk", Bytes(whole.begin(), whole.begin() + 200));
  out.write("corrupt-cut-at-end.fbk", Bytes(whole.begin(), whole.end() - 1));
  (other = whole).push_back(std::byte(0));
  out.write("corrupt-byte-more.fbk", other);
  (other = whole)[whole.size() / 2] ^= std::byte(4);
  out.write("corrupt-bit.fbk", other);
  (other = whole).back() ^= std::byte(0x80);
  out.write("corrupt-checksum.fbk", other);
  patch(other = whole, table_at(1, 40), std::uint64_t(0));
  out.write("corrupt-overlap.fbk", sealed(other));
  write_rejected_rows(out);
  write_rejected_streams(out);
}

void write_rejected_sections(const RejectedWriter& out) {
  out.write("unsupported-major.fbk", edited([](ArchiveEditor& archive) { archive.major = 3; }));
  out.write("unsupported-required.fbk", edited([](ArchiveEditor& archive) {
              archive["hair"].set(text("something newer"));
              archive["hair"].flags = section_required;
            }));
  out.write("unsupported-flags.fbk", edited([](ArchiveEditor& archive) { archive["proof"].flags = 2; }));
  out.write("unsupported-version-1.fbk", edited([](ArchiveEditor& archive) { archive.major = 1; }));
  out.write("unsupported-codec.fbk", edited([](ArchiveEditor& archive) { archive["network"].codec = 2; }));
  out.write("corrupt-twice.fbk",
            edited([](ArchiveEditor& archive) { archive.sections.push_back(archive.sections[0]); }));
  out.write("corrupt-missing.fbk",
            edited([](ArchiveEditor& archive) { archive.sections.erase(archive.sections.begin()); }));
  out.write("corrupt-sections-65.fbk", many_sections(max_sections + 1));
  out.write("corrupt-stream-more.fbk", edited([](ArchiveEditor& archive) {
              deflate_section(archive["basis"]);
              archive["basis"].stored.push_back(std::byte(0));
            }));
  out.write("corrupt-stream-size.fbk", edited([](ArchiveEditor& archive) {
              deflate_section(archive["basis"]);
              ++archive["basis"].raw_bytes;
            }));
  for (const char* name :
       {"definition", "polygons", "geometry", "network", "weights", "basis", "basis-values", "proof"}) {
    const std::string file = format("corrupt-%s-more.fbk", name);
    out.write(file.c_str(), changed(name, [](Bytes& b) { b.resize(b.size() + 2); }));
  }
}

}  // namespace fb
