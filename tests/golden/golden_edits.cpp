#include "golden_edits.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>

#include "archive/writer.h"
#include "bake/measure/verify.h"

namespace fb {
using namespace bake;

Bytes text(const std::string& s) {
  const auto bytes = std::as_bytes(std::span(s));
  return {bytes.begin(), bytes.end()};
}

Bytes with_proof(const PackedModel& model) {
  return write_archive(model, make_proof(model, 1), {"Made for tests; no rights reserved.", "{\"dependency\": null}"});
}

Bytes edited(const Edit& edit, const PackedModel& model) {
  ArchiveEditor archive(with_proof(model));
  edit(archive);
  return archive.bytes();
}

Bytes changed(const char* section, const std::function<void(Bytes&)>& change, const PackedModel& model) {
  return edited(
      [&](ArchiveEditor& archive) {
        Bytes contents = archive[section].stored;
        change(contents);
        archive[section].set(contents);
      },
      model);
}

void deflate_section(ArchiveEditor::Section& section, int effort) {
  Bytes packed(compressBound(section.stored.size()));
  uLongf size = packed.size();
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(section.stored.data()),
            section.stored.size(), effort);
  packed.resize(size);
  section.codec = 1;
  section.stored = packed;
}

Bytes without(const std::string& section, const PackedModel& model) {
  return edited(
      [&](ArchiveEditor& archive) {
        std::erase_if(archive.sections, [&](const auto& s) { return s.name == section; });
      },
      model);
}

void rename(Bytes& contents, const std::string& from, const std::string& to) {
  const auto coded = [](const std::string& s) {
    Bytes bytes = numbers({static_cast<std::uint32_t>(s.size())});
    const Bytes letters = text(s);
    bytes.insert(bytes.end(), letters.begin(), letters.end());
    return bytes;
  };
  const Bytes before = coded(from), after = coded(to);
  const auto found = std::search(contents.begin(), contents.end(), before.begin(), before.end());
  if (found == contents.end()) fail(Status::bad_data, "no string \"%s\"", from.c_str());
  const auto at = contents.erase(found, found + static_cast<std::ptrdiff_t>(before.size()));
  contents.insert(at, after.begin(), after.end());
}

void insert(Bytes& contents, std::size_t at, std::initializer_list<std::uint32_t> list) {
  const Bytes bytes = numbers(list);
  contents.insert(contents.begin() + static_cast<std::ptrdiff_t>(at), bytes.begin(), bytes.end());
}

void erase(Bytes& contents, std::size_t at, std::size_t count) {
  const auto first = contents.begin() + static_cast<std::ptrdiff_t>(at);
  contents.erase(first, first + static_cast<std::ptrdiff_t>(count));
}

Bytes numbers(std::initializer_list<std::uint32_t> list) {
  Bytes bytes;
  for (const std::uint32_t number : list) append(bytes, number);
  return bytes;
}

void RejectedWriter::replaced(const char* name, const char* section, const Bytes& contents,
                              const PackedModel& model) const {
  write(name, edited(
                  [&](ArchiveEditor& archive) {
                    archive[section].set(contents);
                    std::erase_if(archive.sections, [](const auto& s) { return s.name == "proof"; });
                  },
                  model));
}

PackedModel smallest() {
  PackedModel model;
  model.schema.controls = {{"c", 0, 1, 0, ""}};
  model.rest.points = {0, 0, 0, 1, 0, 0};
  model.row_blocks = {{0, 6, {}, {}}};
  return model;
}

PackedModel regular(bool polygons) {
  PackedModel model = tiny_packed_model();
  model.rest = grid_mesh(6, 5);
  for (float& x : model.rest.points) x = std::round(256 * x) / 256;
  for (std::size_t v = 0; v < 15; ++v)
    std::swap_ranges(&model.rest.points[3 * v], &model.rest.points[3 * v + 3], &model.rest.points[87 - 3 * v]);
  for (std::uint32_t& corner : model.rest.polygon_corners) corner = 29 - corner;
  if (!polygons) model.rest.polygon_sizes.clear(), model.rest.polygon_corners.clear();
  return model;
}

PackedModel deep_chain(std::uint32_t joints) {
  PackedModel model = smallest();
  DrivenJoints& driven = model.rest.driven;
  for (std::uint32_t j = 0; j < joints; ++j)
    driven.joints.push_back({format("%05u", j),
                             j == 0 || j >= most_joint_depth ? no_joint : j - 1,
                             j == 0 || j == 255 ? 2u : 0u,
                             {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}});
  driven.scales = {0.5f, 1};
  driven.skin = {1, {std::uint16_t(joints - 1), 255}, {1, 1}};
  model.rest.carrier_vertices = 1;
  model.rest.points.insert(model.rest.points.end(), 3, 0.0f);
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.direct = {0};
  model.columns = 1;
  model.row_blocks = {{0, 6, {}, {}}, {6, 3, {{0, false, 0.01f}}, {100, 50, 0}}};
  return model;
}

PackedModel many_rotations() {
  PackedModel model = smallest();
  DrivenJoints& driven = model.rest.driven;
  std::vector<std::uint8_t> outer(most_outer_rotations, 1);
  for (std::size_t o = 0; o < outer.size(); ++o) outer[o] = o == 0 ? 3 : std::uint8_t(1 << o % 3);
  driven.joints = {{"all", no_joint, 1, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, outer},
                   {"one", no_joint, 1, {1, -0.0f, 0, 0, 0, -1, 0, 0, 0, -0.0f, -1, 0}, {1}}};
  driven.scales.assign(driven.number_count(), 0.5f);
  driven.skin = {1, {0, 1}, {1, 1}};
  constexpr std::uint32_t carriers = 7;
  model.rest.carrier_vertices = carriers;
  model.rest.points.insert(model.rest.points.end(), 3 * carriers, 0.0f);
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.direct = {0};
  model.columns = 1;
  std::pmr::vector<std::int16_t> values(3 * carriers);
  for (std::size_t n = 0; n < driven.number_count(); ++n) values[n] = std::int16_t(20 + 5 * n);
  values[driven.number_count() - 1] = 0;
  model.row_blocks = {{0, 6, {}, {}}, {6, 3 * carriers, {{0, false, 0.01f}}, values}};
  return model;
}

PackedModel with_uvs(void (*add_uvs)(Mesh&)) {
  PackedModel model = regular(true);
  add_uvs(model.rest);
  return model;
}

Bytes many_sections(std::size_t count) {
  return edited([&](ArchiveEditor& archive) {
    for (int i = 0; archive.sections.size() < count; ++i) archive[format("!%d~", i)].set({});
  });
}

}  // namespace fb
