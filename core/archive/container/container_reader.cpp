#include "archive/container/container_reader.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <new>

#include "base/hash.h"

namespace fb::archive {
namespace {

using ull = unsigned long long;

// Tells apart, before any other field is read: no archive, an archive damaged in transfer, a truncated one.
void check_signature(std::span<const std::byte> bytes) {
  if (bytes.empty()) fail(Status::not_an_archive, "not an .fbk archive: the file is empty");
  const std::size_t present = std::min(bytes.size(), sizeof archive_signature);
  if (std::memcmp(bytes.data(), archive_signature, present) != 0) {
    if (present > 4 && std::memcmp(bytes.data(), archive_signature, 4) == 0)
      fail(Status::corrupt, "the archive is damaged at byte 4, as if it had been transferred as text");
    fail(Status::not_an_archive, "not an .fbk archive: it does not begin with its signature");
  }
  if (bytes.size() < header_bytes)
    fail(Status::corrupt, "the archive is truncated: it ends at byte %zu, within its header", bytes.size());
}

void check_checksum(std::span<const std::byte> bytes, std::size_t first, std::uint64_t expected, const char* what) {
  if (hash64(bytes) != expected)
    fail(Status::corrupt, "%s (bytes %zu to %zu): the checksum does not match, the archive is damaged", what, first,
         first + bytes.size());
}

std::string read_section_name(ByteReader& table) {
  const auto bytes = table.take(section_name_bytes, "a section name");
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const std::string name(text, strnlen(text, section_name_bytes));
  for (std::size_t i = 0; i < section_name_bytes; ++i)
    if (i < name.size() ? text[i] < 0x21 || text[i] > 0x7e : text[i] != 0)
      table.corrupt("a section name is not printable ASCII");
  if (name.empty()) table.corrupt("a section has no name");
  return name;
}

// Reads a row of the section table and verifies its section, which must begin at `expected_offset`. `end`: the offset
// at which the last section ends.
StoredSection read_row(ByteReader& table, std::span<const std::byte> file, std::uint64_t expected_offset,
                       std::uint64_t end) {
  StoredSection section;
  section.info.name = read_section_name(table);
  const auto flags = table.number<std::uint32_t>("section flags");
  section.codec = static_cast<Codec>(table.number<std::uint32_t>("section codec"));
  section.info.offset = table.number<std::uint64_t>("section offset");
  section.info.stored_bytes = table.number<std::uint64_t>("section size");
  section.info.raw_bytes = table.number<std::uint64_t>("section size");
  const auto checksum = table.number<std::uint64_t>("section checksum");
  section.info.required = (flags & section_required) != 0;

  const std::string where = section.where();
  if (section.info.offset != expected_offset)
    fail(Status::corrupt, "%s %s the part before it, which ends at byte %llu", where.c_str(),
         section.info.offset < expected_offset ? "overlaps" : "does not follow", (ull)expected_offset);
  if (section.info.stored_bytes > end - section.info.offset)
    fail(Status::corrupt, "%s takes %llu bytes and runs past byte %llu, where sections end", where.c_str(),
         (ull)section.info.stored_bytes, (ull)end);
  section.stored = file.subspan(section.info.offset, section.info.stored_bytes);
  check_checksum(section.stored, section.info.offset, checksum, where.c_str());
  if (flags & ~section_required) fail(Status::unsupported, "%s has unknown flags 0x%x", where.c_str(), flags);
  return section;
}

// What zlib allocates to decompress: its window, tables and state.
constexpr std::size_t inflate_bytes = 48 << 10;

void inflate_section(const StoredSection& section, MemoryBudget& budget, std::pmr::vector<std::byte>& raw) {
  const std::string where = section.where();
  if (section.info.raw_bytes > UINT32_MAX || section.info.stored_bytes > UINT32_MAX)
    fail(Status::corrupt, "%s is compressed and larger than 4 GiB", where.c_str());
  const ScopedCharge state(budget, 1, inflate_bytes, where.c_str());
  raw.resize(section.info.raw_bytes);
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(section.stored.data()));
  stream.avail_in = static_cast<uInt>(section.stored.size());
  Bytef unused = 0;
  stream.next_out = raw.empty() ? &unused : reinterpret_cast<Bytef*>(raw.data());
  stream.avail_out = static_cast<uInt>(raw.size());
  const int result = inflate(&stream, Z_FINISH);
  const bool complete = result == Z_STREAM_END && stream.avail_in == 0 && stream.avail_out == 0;
  inflateEnd(&stream);
  if (!complete)
    fail(Status::corrupt, "%s does not decompress to the %llu bytes it declares", where.c_str(), (ull)raw.size());
}

struct Header {
  std::uint32_t sections;
  std::uint64_t size;  // of the whole archive
};

// Checks signature and version.
Header read_header(std::span<const std::byte> bytes) {
  check_signature(bytes);
  MemoryBudget budget;
  ByteReader header(bytes.first(header_bytes), "the header", budget);
  header.take(sizeof archive_signature, "the signature");
  const auto major = header.number<std::uint16_t>("the version");
  const auto minor = header.number<std::uint16_t>("the version");
  const auto count = header.number<std::uint32_t>("the number of sections");
  const auto size = header.number<std::uint64_t>("the size");
  if (major != archive_major)
    fail(Status::unsupported, "the archive has format version %u.%u; this library reads %u.%u", major, minor,
         archive_major, archive_minor);
  if (count > max_sections)
    fail(Status::corrupt, "the header (byte 12) declares %u sections; at most %u are allowed", count, max_sections);
  return {count, size};
}

// Checks the checksum of the table, which ends at table_end, and the size of the file.
void check_table(std::span<const std::byte> bytes, const Header& header, std::size_t table_end) {
  const auto [count, size] = header;
  if (bytes.size() < table_end + 2 * checksum_bytes)
    fail(Status::corrupt, "the archive is truncated: it ends at byte %zu, within its table of %u sections",
         bytes.size(), count);
  MemoryBudget budget;
  ByteReader after_table(bytes.subspan(table_end, checksum_bytes), "the table's checksum", budget);
  check_checksum(bytes.first(table_end), 0, after_table.number<std::uint64_t>("a checksum"),
                 "header and section table");
  if (bytes.size() < size)
    fail(Status::corrupt, "the archive is truncated: it ends at byte %zu of %llu", bytes.size(), (ull)size);
  if (bytes.size() > size)
    fail(Status::corrupt, "the archive ends at byte %llu, and %llu more bytes follow", (ull)size,
         (ull)(bytes.size() - size));
}

}  // namespace

std::string StoredSection::where() const {
  return format("section \"%s\" (byte %llu)", info.name.c_str(), (ull)info.offset);
}

std::span<const std::byte> StoredSection::contents(MemoryBudget& budget, std::pmr::vector<std::byte>& unpacked) const {
  const std::string section = where();
  if (codec != Codec::none && codec != Codec::deflate)
    fail(Status::unsupported, "%s is compressed with unknown codec %u", section.c_str(), static_cast<unsigned>(codec));
  if (codec == Codec::deflate) {
    inflate_section(*this, budget, unpacked);
    return unpacked;
  }
  if (info.raw_bytes != info.stored_bytes)
    fail(Status::corrupt, "%s is not compressed, yet declares %llu bytes stored as %llu", section.c_str(),
         (ull)info.raw_bytes, (ull)info.stored_bytes);
  return stored;
}

std::uint64_t archive_size(std::span<const std::byte> beginning) {
  return read_header(beginning).size;
}

std::vector<StoredSection> read_container(std::span<const std::byte> bytes) {
  const Header header = read_header(bytes);
  const std::uint32_t count = header.sections;
  const std::size_t table_end = header_bytes + count * table_row_bytes;
  check_table(bytes, header, table_end);
  MemoryBudget budget;
  ByteReader table(bytes.subspan(header_bytes, table_end - header_bytes), "the section table (byte 24)", budget);
  const std::size_t sections_end = bytes.size() - checksum_bytes;
  std::vector<StoredSection> sections;
  std::uint64_t offset = table_end + checksum_bytes;
  for (std::uint32_t i = 0; i < count; ++i) {
    StoredSection section = read_row(table, bytes, offset, sections_end);
    if (find_section(sections, section.info.name))
      fail(Status::corrupt, "%s: there already is a section of this name", section.where().c_str());
    offset += section.info.stored_bytes;
    sections.push_back(std::move(section));
  }
  if (offset != sections_end)
    fail(Status::corrupt, "the last section ends at byte %llu, not at byte %zu before the final checksum", (ull)offset,
         sections_end);
  ByteReader trailer(bytes.last(checksum_bytes), "the final checksum", budget);
  check_checksum(bytes.first(sections_end), 0, trailer.number<std::uint64_t>("a checksum"), "the whole archive");
  return sections;
}

const StoredSection* find_section(const std::vector<StoredSection>& sections, std::string_view name) {
  const auto found = std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return s.info.name == name; });
  return found == sections.end() ? nullptr : &*found;
}

const StoredSection& require_section(const std::vector<StoredSection>& sections, const char* name) {
  const StoredSection* section = find_section(sections, name);
  if (!section) fail(Status::corrupt, "the archive has no section \"%s\"", name);
  return *section;
}

}  // namespace fb::archive
