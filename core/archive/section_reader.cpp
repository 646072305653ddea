#include "archive/section_reader.h"

#include "archive/layout.h"

namespace fb {
namespace {

Feature read_feature(ByteReader& in) {
  Feature feature;
  feature.kind = static_cast<Feature::Kind>(in.number<std::uint8_t>("a feature's kind"));
  if (feature.kind > Feature::Kind::minimum)
    fail(Status::unsupported, "%s has a feature of unknown kind %u", in.where().c_str(),
         static_cast<unsigned>(feature.kind));
  if (feature.of_features()) {
    feature.first = in.number<std::uint32_t>("a feature's parts");
    feature.second = in.number<std::uint32_t>("a feature's parts");
    return feature;
  }
  feature.control = in.number<std::uint32_t>("a feature's control");
  feature.scale = in.number<float>("a feature's scale");
  if (feature.kind != Feature::Kind::identity) feature.threshold = in.number<float>("a feature's threshold");
  if (feature.kind == Feature::Kind::hat) feature.fall = in.number<float>("a feature's fall");
  return feature;
}

PackedLayer read_layer(ByteReader& in) {
  PackedLayer layer;
  layer.inputs = in.number<std::uint32_t>("a layer's width");
  layer.outputs = in.number<std::uint32_t>("a layer's width");
  layer.activation = static_cast<Activation>(in.number<std::uint8_t>("an activation"));
  const auto flags = in.number<std::uint8_t>("a layer's flags");
  if (flags & ~(layer_skips | layer_is_wide))
    fail(Status::unsupported, "%s has a layer of unknown flags 0x%x", in.where().c_str(), flags);
  layer.skip = flags & layer_skips;
  layer.wide = flags & layer_is_wide;
  layer.bias = in.numbers<float>(layer.outputs, "biases");
  layer.scales = in.numbers<float>(layer.outputs, "weight scales");
  layer.weights =
      in.whole_numbers(checked_multiply(layer.inputs, layer.outputs, in.where().c_str()), layer.wide, "weights");
  return layer;
}

}  // namespace

Definition read_definition(ByteReader& in) {
  Definition definition;
  RigSchema& schema = definition.schema;
  schema.name = in.string("the name");
  schema.units = in.string("the units");
  schema.up_axis = in.string("the up axis");
  definition.vertices = in.number<std::uint32_t>("the number of vertices");
  if (definition.vertices > max_vertices) in.damaged("more vertices than the format allows");
  const std::uint32_t controls = in.count(20, "controls");
  in.budget().take(controls, sizeof(Control), "controls");
  schema.controls.resize(controls);
  for (Control& control : schema.controls) {
    control.name = in.string("a control's name");
    control.group = in.string("a control's group");
    control.minimum = in.number<float>("a control's minimum");
    control.maximum = in.number<float>("a control's maximum");
    control.rest = in.number<float>("a control's default");
  }
  in.end();
  return definition;
}

void read_polygons(ByteReader& in, std::uint32_t vertices, Mesh& mesh) {
  const auto polygons = in.number<std::uint32_t>("the number of polygons");
  const auto corners = in.number<std::uint32_t>("the number of corners");
  mesh.polygon_sizes = in.planes32(polygons, "polygon sizes");
  std::uint64_t sum = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) sum += size;
  if (sum != corners) in.damaged("polygon sizes do not add up to the number of corners");
  mesh.polygon_corners = in.planes32(corners, "polygon corners");
  // Steps are in zigzag form; each is undone from corners already decoded in place.
  std::size_t at = 0;
  std::uint32_t previous_size = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    for (std::uint32_t k = 0; k < size; ++k, ++at) {
      const std::uint32_t before = corner_before(mesh.polygon_corners, at, k, previous_size);
      const std::uint32_t corner = before + from_zigzag(mesh.polygon_corners[at]);
      if (corner >= vertices) in.damaged("a polygon names a vertex that does not exist");
      mesh.polygon_corners[at] = corner;
    }
    previous_size = size;
  }
  in.end();
}

void read_network(ByteReader& in, PackedModel& model) {
  const std::uint32_t features = in.count(9, "features");
  in.budget().take(features, sizeof(Feature), "features");
  model.features.reserve(features);
  for (std::uint32_t f = 0; f < features; ++f) model.features.push_back(read_feature(in));
  model.direct = in.numbers<std::uint32_t>(in.count(4, "direct coefficients"), "direct coefficients");
  const std::uint32_t regions = in.count(20, "regions");
  in.budget().take(regions, sizeof(PackedRegion), "regions");
  model.regions.resize(regions);
  for (PackedRegion& region : model.regions) {
    region.name = in.string("a region's name");
    region.features = in.numbers<std::uint32_t>(in.count(4, "region features"), "region features");
    region.gate.features = in.numbers<std::uint32_t>(in.count(4, "gate features"), "gate features");
    region.gate.slope = in.number<float>("a gate's slope");
    const std::uint32_t layers = in.count(18, "layers");
    in.budget().take(layers, sizeof(PackedLayer), "layers");
    region.layers.reserve(layers);
    for (std::uint32_t l = 0; l < layers; ++l) region.layers.push_back(read_layer(in));
  }
  in.end();
}

void read_basis(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  model.columns = in.number<std::uint32_t>("the number of columns");
  const auto ordered = in.number<std::uint32_t>("the order flag");
  if (ordered > 1) in.damaged("the order flag is neither 0 nor 1");
  if (ordered) {
    model.order = in.planes32(vertices, "the order");
    std::uint32_t vertex = 0;
    for (std::uint32_t& step : model.order) step = vertex += from_zigzag(step);
  }
  const std::uint32_t groups = in.count(8, "row groups");
  const std::vector<std::uint32_t> row_counts = in.numbers<std::uint32_t>(groups, "row counts");
  const std::vector<std::uint32_t> column_counts = in.numbers<std::uint32_t>(groups, "column counts");
  std::uint64_t row = 0, columns = 0;
  for (const std::uint32_t count : row_counts) row += count;
  for (const std::uint32_t count : column_counts) columns += count;
  if (row != 3 * std::uint64_t(vertices)) in.damaged("row groups do not add up to the number of rows");
  const std::vector<std::uint32_t> steps = in.planes32(columns, "column steps");
  const std::vector<std::uint8_t> wide = in.numbers<std::uint8_t>(columns, "width flags");
  const std::vector<float> scales = in.numbers<float>(columns, "scales");
  in.budget().take(groups, sizeof(PackedRowGroup), "row groups");
  in.budget().take(columns, sizeof(PackedColumn), "columns");
  model.groups.resize(groups);
  std::uint32_t first_row = 0;
  std::size_t at = 0;
  std::uint64_t narrow_values = 0, wide_values = 0;
  for (std::size_t g = 0; g < groups; ++g) {
    PackedRowGroup& group = model.groups[g];
    group.first_row = first_row;
    first_row += group.row_count = row_counts[g];
    group.columns.resize(column_counts[g]);
    std::uint32_t number = 0;
    for (PackedColumn& column : group.columns) {
      if (wide[at] > 1) in.damaged("a width flag is neither 0 nor 1");
      column = {number += steps[at], wide[at] == 1, scales[at]};
      (column.wide ? wide_values : narrow_values) += group.row_count;
      ++at;
    }
  }
  const std::vector<std::int16_t> narrow_ones = in.whole_numbers(narrow_values, false, "narrow values");
  const std::vector<std::int16_t> wide_ones = in.whole_numbers(wide_values, true, "wide values");
  in.end();
  in.budget().take(narrow_values + wide_values, sizeof(std::int16_t), in.where().c_str());
  auto next_narrow = narrow_ones.begin(), next_wide = wide_ones.begin();
  for (PackedRowGroup& group : model.groups) {
    group.values.reserve(group.columns.size() * group.row_count);
    for (const PackedColumn& column : group.columns) {
      auto& next = column.wide ? next_wide : next_narrow;
      group.values.insert(group.values.end(), next, next + group.row_count);
      next += group.row_count;
    }
  }
}

Proof read_proof(ByteReader& in, std::size_t controls, std::uint32_t vertices) {
  Proof proof;
  const auto poses = in.number<std::uint32_t>("the number of poses");
  proof.vertices = in.numbers<std::uint32_t>(in.count(4, "proof vertices"), "proof vertices");
  for (const std::uint32_t vertex : proof.vertices)
    if (vertex >= vertices) in.damaged("the proof names a vertex that does not exist");
  proof.controls = in.numbers<float>(checked_multiply(poses, controls, "proof controls"), "proof controls");
  proof.positions =
      in.numbers<float>(checked_multiply(poses, checked_multiply(proof.vertices.size(), 3, "proof"), "proof positions"),
                        "proof positions");
  in.end();
  return proof;
}

}  // namespace fb
