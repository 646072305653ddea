#include "archive/reader.h"

#include "archive/container.h"
#include "archive/section_reader.h"

namespace fb {
namespace {

// Unpacks one section and hands it to `read`; gives back what that returns.
template <class Read>
auto open(const std::vector<StoredSection>& sections, const char* name, Budget& budget, Read&& read) {
  const StoredSection* section = find_section(sections, name);
  if (!section) fail(Status::corrupt, "the archive has no section \"%s\"", name);
  const std::vector<std::byte> raw = section->unpack(budget);
  ByteReader in(raw, section->where(), budget);
  return read(in);
}

bool known(std::string_view name) {
  for (const char* k : {section::definition, section::polygons, section::geometry, section::network, section::basis,
                        section::provenance, section::proof})
    if (name == k) return true;
  return false;
}

// The parts are sound by themselves; what follows is whether they fit each other, and whether numbers are finite.
void check_whole(const PackedModel& model) {
  try {
    check(model);
  } catch (const Error& error) {
    if (error.status() == Status::unsupported) throw;
    fail(Status::corrupt, "the archive contradicts itself: %s", error.what());
  }
}

}  // namespace

std::uint32_t archive_format_version() {
  return archive_major * 1000u + archive_minor;
}

Archive read_archive(std::span<const std::byte> bytes, const ReadLimits& limits) {
  const std::vector<StoredSection> sections = read_container(bytes);
  Archive archive;
  archive.format_version = archive_format_version();
  for (const StoredSection& section : sections) {
    archive.sections.push_back(section.info);
    if (known(section.info.name)) continue;
    if (section.info.required)
      fail(Status::unsupported, "%s is required and unknown to this library", section.where().c_str());
    archive.notes.push_back(format("%s is unknown and was skipped", section.where().c_str()));
  }

  Budget budget(limits.max_model_bytes);
  PackedModel& model = archive.model;
  Definition definition = open(sections, section::definition, budget, read_definition);
  model.schema = std::move(definition.schema);
  open(sections, section::polygons, budget,
       [&](ByteReader& in) { read_polygons(in, definition.vertices, model.rest); });
  std::uint64_t triangles = 0;
  for (const std::uint32_t size : model.rest.polygon_sizes) triangles += size > 2 ? size - 2 : 0;
  model.rest.points = open(sections, section::geometry, budget,
                           [&](ByteReader& in) { return read_geometry(in, definition.vertices, triangles); });
  open(sections, section::network, budget, [&](ByteReader& in) { read_network(in, model); });
  open(sections, section::basis, budget, [&](ByteReader& in) { read_basis(in, definition.vertices, model); });
  if (const StoredSection* provenance = find_section(sections, section::provenance)) {
    const std::vector<std::byte> raw = provenance->unpack(budget);
    model.provenance.assign(reinterpret_cast<const char*>(raw.data()), raw.size());
    if (model.provenance.find('\0') != std::string::npos)
      fail(Status::corrupt, "%s holds a zero byte", provenance->where().c_str());
  }
  check_whole(model);
  if (find_section(sections, section::proof))
    archive.proof = open(sections, section::proof, budget, [&](ByteReader& in) {
      return read_proof(in, model.schema.control_count(), definition.vertices);
    });
  return archive;
}

}  // namespace fb
