#include "archive/reader.h"

#include "archive/container/container.h"
#include "archive/section_reader.h"

namespace fb::archive {
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
  for (const char* k : {section::definition, section::polygons, section::geometry, section::network, section::weights,
                        section::basis, section::basis_values, section::uvs, section::provenance, section::licence,
                        section::certificate, section::proof})
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

Archive read_archive(std::span<const std::byte> bytes, const ReadLimits& limits, Layers layers) {
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
  const auto part = [&](const char* name, auto&& read) { return open(sections, name, budget, read); };
  Definition definition = part(section::definition, read_definition);
  model.schema = std::move(definition.schema);
  const std::uint32_t vertices = archive.vertices = definition.vertices;
  const bool mesh = has(layers, Layers::mesh), behaviour = has(layers, Layers::behaviour);
  if (mesh || behaviour) {
    RestPoints rest = part(section::geometry, [&](ByteReader& in) { return read_geometry(in, vertices); });
    part(section::polygons, [&](ByteReader& in) { read_polygons(in, vertices, rest.triangles, model.rest); });
    if (mesh) model.rest.points = std::move(rest.points);
    if (mesh && find_section(sections, section::uvs))
      part(section::uvs, [&](ByteReader& in) { read_uvs(in, vertices, model.rest); });
  }
  if (behaviour) {
    part(section::network, [&](ByteReader& in) { read_network(in, model); });
    part(section::weights, [&](ByteReader& in) { read_weights(in, model); });
    part(section::basis, [&](ByteReader& in) { read_basis(in, vertices, model); });
    part(section::basis_values, [&](ByteReader& in) { read_basis_values(in, vertices, model); });
  }
  const auto text = [&](const char* name) {
    return has(layers, Layers::text) && find_section(sections, name) ? part(name, read_text) : std::string();
  };
  model.provenance = text(section::provenance);
  archive.text.licence = text(section::licence);
  archive.text.certificate = text(section::certificate);
  if (mesh && behaviour) check_whole(model);
  if (has(layers, Layers::proof) && find_section(sections, section::proof))
    archive.proof =
        part(section::proof, [&](ByteReader& in) { return read_proof(in, model.schema.control_count(), vertices); });
  return archive;
}

}  // namespace fb::archive
