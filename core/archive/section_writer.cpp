#include "archive/section_writer.h"

#include "archive/layout.h"
#include "base/checked.h"

namespace fb {
namespace {

void write_count(ByteWriter& out, std::size_t count, const char* what) {
  out.number(checked_u32(count, what));
}

void write_feature(ByteWriter& out, const Feature& feature) {
  out.number(static_cast<std::uint8_t>(feature.kind));
  if (feature.of_features()) {
    out.number(feature.first);
    out.number(feature.second);
    return;
  }
  out.number(feature.control);
  out.number(feature.scale);
  if (feature.kind != Feature::Kind::identity) out.number(feature.threshold);
  if (feature.kind == Feature::Kind::hat) out.number(feature.fall);
}

void write_list(ByteWriter& out, const std::vector<std::uint32_t>& list, const char* what) {
  write_count(out, list.size(), what);
  out.numbers(list);
}

void write_layer(ByteWriter& out, const PackedLayer& layer) {
  out.number(layer.inputs);
  out.number(layer.outputs);
  out.number(static_cast<std::uint8_t>(layer.activation));
  out.number(static_cast<std::uint8_t>((layer.skip ? layer_skips : 0) | (layer.wide ? layer_is_wide : 0)));
  out.numbers(layer.bias);
  out.numbers(layer.scales);
  out.whole_numbers(layer.weights, layer.wide);
}

}  // namespace

ByteWriter write_definition(const PackedModel& model) {
  const RigSchema& schema = model.schema;
  ByteWriter out;
  out.string(schema.name, "the rig's name");
  out.string(schema.units, "the units");
  out.string(schema.up_axis, "the up axis");
  if (model.rest.vertex_count() > max_vertices)
    fail(Status::limit, "%zu vertices; an archive holds %u", model.rest.vertex_count(), max_vertices);
  write_count(out, model.rest.vertex_count(), "vertices");
  write_count(out, schema.control_count(), "controls");
  for (const Control& control : schema.controls) {
    out.string(control.name, "a control's name");
    out.string(control.group, "a control's group");
    out.number(control.minimum);
    out.number(control.maximum);
    out.number(control.rest);
  }
  return out;
}

ByteWriter write_polygons(const Mesh& mesh) {
  ByteWriter out;
  write_count(out, mesh.polygon_sizes.size(), "polygons");
  write_count(out, mesh.polygon_corners.size(), "polygon corners");
  out.planes(mesh.polygon_sizes);
  // Neighbouring polygons have neighbouring corners, so their differences are small and alike.
  std::vector<std::uint32_t> zigzag;
  std::size_t at = 0;
  std::uint32_t previous_size = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    for (std::uint32_t k = 0; k < size; ++k, ++at) {
      const std::uint32_t before = corner_before(mesh.polygon_corners, at, k, previous_size);
      zigzag.push_back(to_zigzag(mesh.polygon_corners[at] - before));
    }
    previous_size = size;
  }
  out.planes(zigzag);
  return out;
}

ByteWriter write_network(const PackedModel& model) {
  ByteWriter out;
  write_count(out, model.features.size(), "features");
  for (const Feature& feature : model.features) write_feature(out, feature);
  write_list(out, model.direct, "direct coefficients");
  write_count(out, model.regions.size(), "regions");
  for (const PackedRegion& region : model.regions) {
    out.string(region.name, "a region's name");
    write_list(out, region.features, "region features");
    write_list(out, region.gate.features, "gate features");
    out.number(region.gate.slope);
    write_count(out, region.layers.size(), "layers");
    for (const PackedLayer& layer : region.layers) write_layer(out, layer);
  }
  return out;
}

ByteWriter write_basis(const PackedModel& model) {
  ByteWriter out;
  out.number(model.columns);
  out.number(std::uint32_t(!model.order.empty()));
  std::vector<std::uint32_t> steps;
  std::uint32_t before = 0;
  for (const std::uint32_t vertex : model.order) {
    steps.push_back(to_zigzag(vertex - before));
    before = vertex;
  }
  out.planes(steps);
  steps.clear();
  write_count(out, model.groups.size(), "row groups");
  for (const PackedRowGroup& group : model.groups) out.number(group.row_count);
  for (const PackedRowGroup& group : model.groups) write_count(out, group.columns.size(), "columns");
  std::vector<std::uint8_t> wide;
  std::vector<float> scales;
  std::vector<std::int16_t> narrow_values, wide_values;
  for (const PackedRowGroup& group : model.groups) {
    before = 0;
    auto first = group.values.begin();
    for (const PackedColumn& column : group.columns) {
      steps.push_back(column.column - before);
      before = column.column;
      wide.push_back(column.wide);
      scales.push_back(column.scale);
      auto& values = column.wide ? wide_values : narrow_values;
      values.insert(values.end(), first, first + group.row_count);
      first += group.row_count;
    }
  }
  out.planes(steps);
  out.numbers(wide);
  out.numbers(scales);
  out.whole_numbers(narrow_values, false);
  out.whole_numbers(wide_values, true);
  return out;
}

ByteWriter write_proof(const Proof& proof, const PackedModel& model) {
  const std::size_t controls = model.schema.control_count();
  const std::size_t poses = proof.controls.size() / controls;
  if (proof.controls.size() != poses * controls || proof.positions.size() != poses * proof.vertices.size() * 3)
    fail(Status::bad_data, "the proof has %zu control values and %zu coordinates for %zu controls and %zu vertices",
         proof.controls.size(), proof.positions.size(), controls, proof.vertices.size());
  for (const std::uint32_t vertex : proof.vertices)
    if (vertex >= model.rest.vertex_count())
      fail(Status::bad_data, "the proof names vertex %u of %zu", vertex, model.rest.vertex_count());
  ByteWriter out;
  write_count(out, poses, "proof poses");
  write_count(out, proof.vertices.size(), "proof vertices");
  out.numbers(proof.vertices);
  out.numbers(proof.controls);
  out.numbers(proof.positions);
  return out;
}

}  // namespace fb
