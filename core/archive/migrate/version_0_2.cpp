#include "archive/migrate/version_0_2.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "archive/container/container.h"
#include "archive/section_reader.h"
#include "base/checked.h"

namespace fb::archive {
namespace {

constexpr FormatVersion version = {0, 2};

std::vector<std::byte> unpacked(const StoredSection& section, Budget& budget) {
  if (section.codec != Codec::zstd) return section.unpack(budget);
  const std::string place = section.where();
  budget.take(section.info.raw_bytes, 1, place.c_str());
  std::vector<std::byte> raw(section.info.raw_bytes);
  const std::size_t got = ZSTD_decompress(raw.data(), raw.size(), section.stored.data(), section.stored.size());
  if (ZSTD_isError(got) || got != raw.size()) fail(Status::corrupt, "%s cannot be unpacked", place.c_str());
  return raw;
}

void read_layer_weights(ByteReader& in, PackedLayer& layer) {
  layer.weights =
      in.whole_numbers(checked_multiply(layer.inputs, layer.outputs, in.where().c_str()), layer.wide, "weights");
}

// Row groups with their columns and numbers, one group after the other.
void read_row_blocks(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  model.columns = in.number<std::uint32_t>("the number of columns");
  if (in.number<std::uint32_t>("the order flag") != 0) {
    model.order = in.planes32(vertices, "the order");
    std::uint32_t vertex = 0;
    for (std::uint32_t& step : model.order) step = vertex += from_zigzag(step);
  }
  const std::uint32_t groups = in.count(8, "row groups");
  const std::vector<std::uint32_t> rows = in.numbers<std::uint32_t>(groups, "row counts");
  const std::vector<std::uint32_t> counts = in.numbers<std::uint32_t>(groups, "column counts");
  std::uint64_t columns = 0;
  for (const std::uint32_t count : counts) columns += count;
  const std::vector<std::uint32_t> steps = in.planes32(columns, "column steps");
  const std::vector<std::uint8_t> wide = in.numbers<std::uint8_t>(columns, "width flags");
  const std::vector<float> scales = in.numbers<float>(columns, "scales");
  std::uint64_t numbers[2] = {};
  std::uint32_t row = 0;
  std::size_t at = 0;
  for (std::uint32_t g = 0; g < groups; ++g) {
    PackedRowBlock& group = model.groups.emplace_back();
    group.first_row = row;
    row += group.row_count = rows[g];
    std::uint32_t column = 0;
    for (std::uint32_t c = 0; c < counts[g]; ++c, ++at) {
      group.columns.push_back({column += steps[at], wide[at] != 0, scales[at]});
      numbers[wide[at] != 0] += rows[g];
    }
  }
  const std::vector<std::int16_t> values[2] = {in.whole_numbers(numbers[0], false, "narrow values"),
                                               in.whole_numbers(numbers[1], true, "wide values")};
  in.end();
  const std::int16_t* next[2] = {values[0].data(), values[1].data()};
  for (PackedRowBlock& group : model.groups)
    for (const PackedColumn& column : group.columns) {
      group.values.insert(group.values.end(), next[column.wide], next[column.wide] + group.row_count);
      next[column.wide] += group.row_count;
    }
}

}  // namespace

bool is_version_0_2(std::span<const std::byte> bytes) {
  constexpr unsigned char beginning[12] = {0x89, 'F', 'B', 'K', 0x0d, 0x0a, 0x1a, 0x0a, 0, 0, 2, 0};
  return bytes.size() >= sizeof beginning && std::memcmp(bytes.data(), beginning, sizeof beginning) == 0;
}

Archive read_version_0_2(std::span<const std::byte> bytes, const ReadLimits& limits) {
  const std::vector<StoredSection> sections = read_container(bytes, version);
  Budget budget(limits.max_model_bytes);
  const auto part = [&](const char* name, auto&& read) {
    const StoredSection* section = find_section(sections, name);
    if (!section) fail(Status::corrupt, "the archive has no section \"%s\"", name);
    const std::vector<std::byte> raw = unpacked(*section, budget);
    ByteReader in(raw, section->where(), budget);
    return read(in);
  };
  Archive archive;
  archive.format_version = version.major * 1000u + version.minor;
  for (const StoredSection& section : sections) archive.sections.push_back(section.info);
  PackedModel& model = archive.model;
  Definition definition = part(section::definition, read_definition);
  model.schema = std::move(definition.schema);
  const std::uint32_t vertices = archive.vertices = definition.vertices;
  part(section::polygons, [&](ByteReader& in) {
    const std::uint32_t corners = read_polygon_sizes(in, model.rest);
    read_polygon_steps(in, vertices, corners, model.rest);
  });
  std::uint64_t triangles = 0;
  for (const std::uint32_t size : model.rest.polygon_sizes) triangles += size > 2 ? size - 2 : 0;
  model.rest.points = part(section::geometry, [&](ByteReader& in) {
    const auto order = static_cast<PointOrder>(in.number<std::uint32_t>("the order of points"));
    return read_draco(in, order, vertices, order == PointOrder::by_index ? triangles : 0, 0).points;
  });
  part(section::network, [&](ByteReader& in) { read_network(in, model, read_layer_weights); });
  part(section::basis, [&](ByteReader& in) { read_row_blocks(in, vertices, model); });
  if (find_section(sections, section::provenance)) model.provenance = part(section::provenance, read_text);
  for (PackedRegion& region : model.regions)
    std::sort(region.gate.features.begin(), region.gate.features.end(), [&](std::uint32_t a, std::uint32_t b) {
      return a < model.features.size() && b < model.features.size()
                 ? model.features[a].control < model.features[b].control
                 : a < b;
    });
  check(model);
  return archive;
}

}  // namespace fb::archive
