#include "archive/reader.h"

#include <algorithm>
#include <initializer_list>

#include "archive/character_reader.h"
#include "archive/coding/coding_reader.h"
#include "archive/geometry/geometry_reader.h"
#include "archive/level_reader.h"
#include "archive/section_reader.h"

namespace fb::archive {
namespace {

bool is_known(std::string_view name) {
  for (const char* known :
       {section::definition,   section::polygons,     section::geometry, section::network,     section::weights,
        section::basis,        section::basis_values, section::labels,   section::uvs,         section::meshes,
        section::materials,    section::images,       section::sockets,  section::channels,    section::expected_errors,
        section::joints,       section::skin,         section::about,    section::thumbnail,   section::provenance,
        section::licence,      section::certificate,  section::proof,    section::exact_poses, section::levels,
        section::driven_joints})
    if (name == known) return true;
  return false;
}

// Reads sections into an archive. Each section is decompressed, if it is compressed, read and released before the next.
class ArchiveReader {
  bool contains(const char* name) const { return find_section(sections_, name) != nullptr; }

  template <class Read>
  auto read(const char* name, Read&& read) {
    const StoredSection& section = require_section(sections_, name);
    std::pmr::vector<std::byte> unpacked(&budget_);
    ByteReader in(section.contents(budget_, unpacked), section.where(), budget_);
    return read(in);
  }

 public:
  ArchiveReader(const std::vector<StoredSection>& sections, const ReadLimits& limits, MemoryBudget& budget,
                const Parallel& parallel)
      : sections_(sections), limits_(limits), budget_(budget), parallel_(parallel) {}

  void list_sections() {
    for (const StoredSection& section : sections_) {
      archive.sections.push_back(section.info);
      if (is_known(section.info.name)) continue;
      if (section.info.required)
        fail(Status::unsupported, "%s is required and unknown to this library", section.where().c_str());
      archive.notes.push_back(format("%s is unknown and was skipped", section.where().c_str()));
    }
  }

  void read_definition_section() {
    Definition definition = read(section::definition, read_definition);
    model_.schema = std::move(definition.schema);
    archive.vertices = definition.vertices;
    check_limit(archive.vertices, limits_.max_vertices, "vertices");
    const RigSchema& schema = model_.schema;
    count_names({&schema.name, &schema.units, &schema.up_axis});
    if (contains(section::labels)) read(section::labels, [&](ByteReader& in) { read_labels(in, model_.schema); });
    for (const Control& control : schema.controls)
      count_names({&control.name, &control.group, &control.labels.arkit, &control.labels.facs, &control.labels.unit});
    if (contains(section::channels)) model_.schema.channels = read(section::channels, read_channels);
    for (const Channel& channel : schema.channels) count_names({&channel.name, &channel.unit});
    DrivenJoints& driven = model_.rest.driven;
    if (contains(section::driven_joints))
      driven = read(section::driven_joints, [&](ByteReader& in) { return read_driven_joints(in, archive.vertices); });
    for (const DrivenJoint& joint : driven.joints) count_names({&joint.name});
    model_.rest.carrier_vertices =
        static_cast<std::uint32_t>((schema.channels.size() + 2) / 3 + (driven.number_count() + 2) / 3);
  }

  // Positions and texture coordinates are kept only with `mesh`; polygons are needed to decode the basis, too.
  void read_mesh(bool mesh) {
    const std::uint32_t vertices = archive.vertices;
    RestPoints rest = read(section::geometry, [&](ByteReader& in) { return read_geometry(in, vertices); });
    read(section::polygons, [&](ByteReader& in) { read_polygons(in, vertices, rest.triangles, model_.rest); });
    check_limit(model_.rest.polygon_sizes.size(), limits_.max_polygons, "polygons");
    if (!mesh) return;
    model_.rest.points = std::move(rest.points);
    budget_.resize(model_.rest.points, 3 * std::size_t(archive.vertices + model_.rest.carrier_vertices),
                   "channels and joints");
    if (contains(section::uvs)) read(section::uvs, [&](ByteReader& in) { read_uvs(in, vertices, model_.rest); });
    if (contains(section::meshes)) model_.rest.parts = read(section::meshes, read_meshes);
    for (const MeshPart& part : model_.rest.parts) count_names({&part.name});
    read_character();
  }

  void read_character() {
    Character& character = model_.character;
    if (contains(section::materials)) character.materials = read(section::materials, read_materials);
    for (const Material& material : character.materials) count_names({&material.name});
    if (contains(section::images)) character.images = read(section::images, read_images);
    for (const Image& image : character.images) count_names({&image.name, &image.media_type});
    if (contains(section::joints)) character.joints = read(section::joints, read_joints);
    for (const Joint& joint : character.joints) count_names({&joint.name});
    if (contains(section::skin))
      character.skin = read(section::skin, [&](ByteReader& in) { return read_skin(in, archive.vertices); });
    if (contains(section::about)) character.about = read(section::about, read_text);
    count_names({&character.about});
    if (contains(section::thumbnail)) character.thumbnail = read(section::thumbnail, read_thumbnail);
  }

  // A part of the mesh, which the proof needs, too.
  void read_sockets_section() {
    std::vector<Socket>& sockets = model_.character.sockets;
    if (contains(section::sockets)) sockets = read(section::sockets, read_sockets);
    for (const Socket& socket : sockets) count_names({&socket.name});
  }

  // A part of the behaviour, which the proof needs, too.
  void read_errors_section() {
    if (!contains(section::expected_errors)) return;
    const std::size_t controls = model_.schema.control_count();
    model_.expected =
        read(section::expected_errors, [&](ByteReader& in) { return read_expected_errors(in, controls); });
    for (const ExpectedErrors::Region& region : model_.expected.regions) count_names({&region.name});
  }

  // A part of the mesh, which the proof needs, too.
  void read_levels_section() {
    if (!contains(section::levels)) return;
    model_.levels = read(section::levels, read_levels);
    for (const DetailLevel& level : model_.levels)
      check_limit(level.polygon_sizes.size(), limits_.max_polygons, "polygons in a level of detail");
  }

  void read_behaviour() {
    read(section::network, [&](ByteReader& in) { read_network(in, model_); });
    check_limit(model_.features.size(), limits_.max_features, "features");
    for (const PackedRegion& region : model_.regions) count_names({&region.name});
    read(section::weights, [&](ByteReader& in) { read_weights(in, model_); });
    const std::uint32_t vertices = archive.vertices + model_.rest.carrier_vertices;
    const auto tables = read(section::basis, [&](ByteReader& in) { return read_basis(in, vertices, model_); });
    read(section::basis_values, [&](ByteReader& in) { read_basis_values(in, vertices, tables, parallel_, model_); });
    if (!contains(section::exact_poses)) return;
    const std::size_t controls = model_.schema.control_count();
    model_.exact = read(section::exact_poses, [&](ByteReader& in) { return read_exact_poses(in, controls, vertices); });
    for (const ExactPose& pose : model_.exact) count_names({&pose.name});
  }

  void read_texts() {
    const auto text = [&](const char* name) { return contains(name) ? read(name, read_text) : std::string(); };
    model_.provenance = text(section::provenance);
    archive.text.licence = text(section::licence);
    archive.text.certificate = text(section::certificate);
    count_names({&model_.provenance, &archive.text.licence, &archive.text.certificate});
  }

  void read_proof_section() {
    if (contains(section::proof))
      archive.proof = read(section::proof, [&](ByteReader& in) {
        return read_proof(in, model_.schema, archive.vertices,
                          {model_.character.sockets.size(), model_.expected.count(), model_.levels.size(),
                           !model_.rest.driven.empty()});
      });
  }

  // Sections are valid by themselves; this checks that they fit each other and that all numbers are finite.
  void check_model() {
    // What the checks allocate: a set of names, and a mark a vertex.
    const ScopedCharge names(budget_, model_.schema.control_count(), 3 * 96, "control names");
    const ScopedCharge places(budget_, model_.exact.empty() ? 0 : model_.schema.control_count(), 12, "controls");
    const ScopedCharge marks(budget_, archive.vertices / 8 + 1, 1, "marks");
    const ScopedCharge part_names(budget_,
                                  model_.rest.parts.size() + model_.character.sockets.size() +
                                      model_.character.joints.size() + model_.rest.driven.joints.size() +
                                      model_.schema.channels.size() + model_.expected.regions.size() +
                                      model_.exact.size(),
                                  96, "names");
    // Two numbers a vertex, and the triangles of a level.
    std::uint64_t level_numbers = 0;
    for (const DetailLevel& level : model_.levels)
      level_numbers = std::max<std::uint64_t>(level_numbers, 3 * level.polygon_corners.size());
    if (!model_.levels.empty()) level_numbers += 2 * (std::uint64_t(archive.vertices) + model_.rest.carrier_vertices);
    const ScopedCharge levels(budget_, level_numbers, sizeof(std::uint32_t), "levels");
    try {
      check(model_);
      check(model_.character, model_.rest);
    } catch (const Error& error) {
      if (error.status() == Status::unsupported) throw;
      fail(Status::corrupt, "the archive contradicts itself: %s", error.what());
    }
  }

  Archive archive;

 private:
  static void check_limit(std::uint64_t count, std::uint64_t limit, const char* what) {
    if (count > limit)
      fail(Status::limit, "the archive has %llu %s; the limit is %llu", (unsigned long long)count, what,
           (unsigned long long)limit);
  }
  void count_names(std::initializer_list<const std::string*> names) {
    for (const std::string* name : names) name_bytes_ += name->size();
    check_limit(name_bytes_, limits_.max_name_bytes, "bytes of names and texts");
  }

  const std::vector<StoredSection>& sections_;
  const ReadLimits& limits_;
  std::uint64_t name_bytes_ = 0;
  MemoryBudget& budget_;
  const Parallel& parallel_;
  PackedModel& model_ = archive.model;
};

}  // namespace

std::uint32_t archive_format_version() {
  return archive_major * 1000u + archive_minor;
}

std::uint32_t format_version_of(std::span<const std::byte> archive) {
  const auto number = [&](std::size_t at) {
    return std::to_integer<std::uint32_t>(archive[at]) + 256 * std::to_integer<std::uint32_t>(archive[at + 1]);
  };
  return number(8) * 1000 + number(10);
}

Archive read_archive(std::span<const std::byte> bytes, const ReadLimits& limits, Parts parts) {
  MemoryBudget budget(limits.max_model_bytes);
  return read_archive(bytes, limits, parts, budget);
}

Archive read_archive(std::span<const std::byte> bytes, const ReadLimits& limits, Parts parts, MemoryBudget& budget,
                     const Parallel& parallel) {
  const std::vector<StoredSection> sections = read_container(bytes);
  ArchiveReader reader(sections, limits, budget, parallel);
  reader.archive.format_version = format_version_of(bytes);
  reader.list_sections();
  reader.read_definition_section();
  const bool mesh = has(parts, Parts::mesh), behaviour = has(parts, Parts::behaviour);
  if (mesh || behaviour) reader.read_mesh(mesh);
  if (mesh || has(parts, Parts::proof)) {
    reader.read_sockets_section();
    reader.read_levels_section();
  }
  if (behaviour) reader.read_behaviour();
  if (behaviour || has(parts, Parts::proof)) reader.read_errors_section();
  if (has(parts, Parts::text)) reader.read_texts();
  if (mesh && behaviour) reader.check_model();
  if (has(parts, Parts::proof)) reader.read_proof_section();
  return std::move(reader.archive);
}

}  // namespace fb::archive
