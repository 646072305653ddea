#include "archive/migrate/version_0_2.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "archive/container/container_reader.h"
#include "archive/geometry/geometry_reader.h"
#include "archive/section_reader.h"
#include "base/checked.h"

namespace fb::archive {
namespace {

constexpr FormatVersion version = {0, 2};

std::span<const std::byte> decompress(const StoredSection& section, MemoryBudget& budget,
                                      std::pmr::vector<std::byte>& raw) {
  if (section.codec != Codec::zstd) return section.contents(budget, raw);
  const std::string where = section.where();
  if (section.info.raw_bytes > UINT32_MAX)
    fail(Status::limit, "%s is compressed and larger than 4 GiB", where.c_str());
  raw.resize(section.info.raw_bytes);
  const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), section.stored.data(), section.stored.size());
  if (ZSTD_isError(size) || size != raw.size()) fail(Status::corrupt, "%s cannot be decompressed", where.c_str());
  return raw;
}

// Quantised values of 16 bits in two byte planes, low bytes first, or of 8 bits.
std::vector<std::int16_t> read_quantised(ByteReader& in, std::uint64_t count, bool wide, const char* what) {
  const auto bytes = in.take(wide ? checked_multiply(count, 2, in.where().c_str()) : count, what);
  in.budget().take(count, sizeof(std::int16_t), what);
  std::vector<std::int16_t> values(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto low = static_cast<std::uint16_t>(bytes[i]);
    values[i] = wide ? static_cast<std::int16_t>(low | static_cast<std::uint16_t>(bytes[values.size() + i]) << 8)
                     : static_cast<std::int8_t>(low);
  }
  return values;
}

void read_layer_weights(ByteReader& in, PackedLayer& layer) {
  const std::size_t count = checked_multiply(layer.inputs, layer.outputs, in.where().c_str());
  layer.weights = read_quantised(in, count, layer.wide, "weights");
}

void read_order(ByteReader& in, std::uint32_t vertices, std::vector<std::uint32_t>& order) {
  order = in.planes(vertices, "the order");
  std::uint32_t vertex = 0;
  for (std::uint32_t& delta : order) delta = vertex += from_zigzag(delta);
}

// The row blocks with their columns and values, block by block.
void read_row_blocks(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  model.columns = in.number<std::uint32_t>("the number of columns");
  if (in.number<std::uint32_t>("the order flag") != 0) read_order(in, vertices, model.order);
  const std::uint32_t blocks = in.count(8, "row blocks");
  const std::vector<std::uint32_t> rows = in.numbers<std::uint32_t>(blocks, "row counts");
  const std::vector<std::uint32_t> counts = in.numbers<std::uint32_t>(blocks, "column counts");
  std::uint64_t columns = 0;
  for (const std::uint32_t count : counts) columns += count;
  const std::vector<std::uint32_t> deltas = in.planes(columns, "column differences");
  const std::vector<std::uint8_t> wide = in.numbers<std::uint8_t>(columns, "width flags");
  const std::vector<float> scales = in.numbers<float>(columns, "scales");
  std::uint64_t value_counts[2] = {};  // of 8 and of 16 bits
  std::uint32_t row = 0;
  std::size_t at = 0;
  for (std::uint32_t b = 0; b < blocks; ++b) {
    PackedRowBlock& block = model.row_blocks.emplace_back();
    block.first_row = row;
    row += block.row_count = rows[b];
    std::uint32_t column = 0;
    for (std::uint32_t c = 0; c < counts[b]; ++c, ++at) {
      block.columns.push_back({column += deltas[at], wide[at] != 0, scales[at]});
      value_counts[wide[at] != 0] += rows[b];
    }
  }
  const std::vector<std::int16_t> values[2] = {read_quantised(in, value_counts[0], false, "8-bit values"),
                                               read_quantised(in, value_counts[1], true, "16-bit values")};
  in.end();
  const std::int16_t* next[2] = {values[0].data(), values[1].data()};
  for (PackedRowBlock& block : model.row_blocks)
    for (const PackedColumn& column : block.columns) {
      block.values.insert(block.values.end(), next[column.wide], next[column.wide] + block.row_count);
      next[column.wide] += block.row_count;
    }
}

std::vector<float> read_points(ByteReader& in, std::uint32_t vertices, const Mesh& mesh) {
  std::uint64_t triangles = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) triangles += size > 2 ? size - 2 : 0;
  const auto order = static_cast<PointOrder>(in.number<std::uint32_t>("the order of points"));
  return read_draco(in, order, vertices, order == PointOrder::by_index ? triangles : 0, 0).points;
}

void sort_gate_features(PackedModel& model) {
  for (PackedRegion& region : model.regions)
    std::sort(region.gate.features.begin(), region.gate.features.end(), [&](std::uint32_t a, std::uint32_t b) {
      return a < model.features.size() && b < model.features.size()
                 ? model.features[a].control < model.features[b].control
                 : a < b;
    });
}

}  // namespace

bool is_version_0_2(std::span<const std::byte> bytes) {
  constexpr unsigned char beginning[12] = {0x89, 'F', 'B', 'K', 0x0d, 0x0a, 0x1a, 0x0a, 0, 0, 2, 0};
  return bytes.size() >= sizeof beginning && std::memcmp(bytes.data(), beginning, sizeof beginning) == 0;
}

Archive read_version_0_2(std::span<const std::byte> bytes, const ReadLimits& limits) {
  const std::vector<StoredSection> sections = read_container(bytes, version);
  MemoryBudget budget(limits.max_model_bytes);
  const auto read = [&](const char* name, auto&& read_contents) {
    const StoredSection& section = require_section(sections, name);
    std::pmr::vector<std::byte> unpacked(&budget);
    ByteReader in(decompress(section, budget, unpacked), section.where(), budget);
    return read_contents(in);
  };
  Archive archive;
  archive.format_version = version.major * 1000u + version.minor;
  for (const StoredSection& section : sections) archive.sections.push_back(section.info);
  PackedModel& model = archive.model;
  Definition definition = read(section::definition, read_definition);
  model.schema = std::move(definition.schema);
  const std::uint32_t vertices = archive.vertices = definition.vertices;
  read(section::polygons, [&](ByteReader& in) {
    const std::uint32_t corners = read_polygon_sizes(in, model.rest);
    read_polygon_deltas(in, vertices, corners, model.rest);
  });
  model.rest.points = read(section::geometry, [&](ByteReader& in) { return read_points(in, vertices, model.rest); });
  read(section::network, [&](ByteReader& in) { read_network(in, model, read_layer_weights); });
  read(section::basis, [&](ByteReader& in) { read_row_blocks(in, vertices, model); });
  if (find_section(sections, section::provenance)) model.provenance = read(section::provenance, read_text);
  sort_gate_features(model);
  check(model);
  return archive;
}

}  // namespace fb::archive
