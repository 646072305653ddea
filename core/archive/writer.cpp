#include "archive/writer.h"

#include "archive/character_writer.h"
#include "archive/coding/writer/coding_writer.h"
#include "archive/container/container_writer.h"
#include "archive/geometry/geometry_writer.h"
#include "archive/level_writer.h"
#include "archive/section_writer.h"

namespace fb::archive {

std::vector<std::byte> write_archive(const PackedModel& model, const Proof& proof, const ArchiveText& text) {
  check(model);
  check(model.character, model.rest);
  std::vector<WrittenSection> sections;
  const auto compress = [&](const char* name, bool required, ByteWriter contents) {
    sections.push_back(compressed_section(name, required, std::move(contents.bytes)));
  };
  const auto store = [&](const char* name, bool required, ByteWriter contents) {
    sections.push_back(uncompressed_section(name, required, std::move(contents.bytes)));
  };
  const auto write_optional_text = [&](const char* name, const std::string& words) {
    if (!words.empty()) compress(name, false, write_text(words, name));
  };
  compress(section::definition, true, write_definition(model));
  if (has_labels(model.schema)) compress(section::labels, false, write_labels(model.schema));
  auto [geometry, triangles] = write_geometry(model.rest);
  compress(section::polygons, true, write_polygons(model.rest, triangles));
  compress(section::geometry, true, std::move(geometry));
  compress(section::network, true, write_network(model));
  store(section::weights, true, write_weights(model));
  auto [columns, values] = write_basis(model);
  compress(section::basis, true, std::move(columns));
  store(section::basis_values, true, std::move(values));
  if (!model.rest.uvs.empty()) compress(section::uvs, false, write_uvs(model.rest));
  if (!model.rest.parts.empty()) compress(section::meshes, false, write_meshes(model.rest.parts));
  const Character& character = model.character;
  if (!character.materials.empty()) compress(section::materials, false, write_materials(character.materials));
  if (!character.images.empty()) compress(section::images, false, write_images(character.images));
  if (!character.sockets.empty()) compress(section::sockets, false, write_sockets(character.sockets));
  if (!character.joints.empty()) compress(section::joints, false, write_joints(character.joints));
  if (character.skin.influences > 0) compress(section::skin, false, write_skin(character.skin));
  write_optional_text(section::about, character.about);
  if (!character.thumbnail.empty()) {
    ByteWriter png;
    png.raw(character.thumbnail);
    store(section::thumbnail, false, std::move(png));
  }
  if (!model.schema.channels.empty()) compress(section::channels, true, write_channels(model.schema.channels));
  if (!model.expected.regions.empty()) compress(section::expected_errors, false, write_expected_errors(model.expected));
  if (!model.exact.empty()) compress(section::exact_poses, true, write_exact_poses(model.exact));
  if (!model.rest.driven.empty()) compress(section::driven_joints, true, write_driven_joints(model.rest.driven));
  if (!model.levels.empty()) compress(section::levels, false, write_levels(model));
  write_optional_text(section::provenance, model.provenance);
  write_optional_text(section::licence, text.licence);
  write_optional_text(section::certificate, text.certificate);
  if (!proof.hashes.empty()) compress(section::proof, false, write_proof(proof, model));
  return assemble_container(sections, model.rest.driven.empty() ? 0 : 1);
}

}  // namespace fb::archive
