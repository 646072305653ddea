#include "archive/section_writer.h"

#include <cmath>

#include "archive/layout.h"
#include "base/checked.h"

namespace fb {
namespace {

// Rounds rows of equal length to 16 bits with one scale each, as FORMAT.md ("Quantisation") states.
struct Quantized {
  std::vector<float> scales;
  std::vector<std::int16_t> values;

  void add_row(const float* row, std::size_t count) {
    float largest = 0;
    for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, std::fabs(row[i]));
    const float scale = largest < 0x1p-100f ? 0 : largest / 32767;
    scales.push_back(scale);
    for (std::size_t i = 0; i < count; ++i) {
      const double steps = scale == 0 ? 0 : std::nearbyint(double(row[i]) / scale);
      values.push_back(static_cast<std::int16_t>(std::clamp(steps, -32767.0, 32767.0)));
    }
  }
};

void write_layer(ByteWriter& out, const DenseLayer& layer) {
  out.number(layer.inputs);
  out.number(layer.outputs);
  out.number(static_cast<std::uint32_t>(layer.activation));
  out.number(std::uint32_t(layer.skip));
  out.numbers(layer.bias);
  Quantized weights;
  for (std::size_t o = 0; o < layer.outputs; ++o)
    weights.add_row(layer.weights.data() + o * layer.inputs, layer.inputs);
  out.numbers(weights.scales);
  out.planes(weights.values);
}

void write_count(ByteWriter& out, std::size_t count, const char* what) {
  out.number(checked_u32(count, what));
}

}  // namespace

ByteWriter write_definition(const FaceModel& model) {
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
      const auto step = static_cast<std::int32_t>(mesh.polygon_corners[at] - before);
      zigzag.push_back(static_cast<std::uint32_t>(step) << 1 ^ static_cast<std::uint32_t>(step >> 31));
    }
    previous_size = size;
  }
  out.planes(zigzag);
  return out;
}

ByteWriter write_network(const Network& network) {
  ByteWriter out;
  write_count(out, network.features.size(), "features");
  for (const Feature& feature : network.features) {
    out.number(static_cast<std::uint32_t>(feature.kind));
    out.number(feature.control);
    out.number(feature.scale);
    out.number(feature.threshold);
  }
  write_count(out, network.direct.size(), "direct coefficients");
  out.numbers(network.direct);
  write_count(out, network.regions.size(), "regions");
  for (const Region& region : network.regions) {
    out.string(region.name, "a region's name");
    write_count(out, region.features.size(), "region features");
    out.numbers(region.features);
    write_count(out, region.layers.size(), "layers");
    for (const DenseLayer& layer : region.layers) write_layer(out, layer);
  }
  return out;
}

ByteWriter write_basis(const Basis& basis) {
  ByteWriter out;
  out.number(basis.rows);
  out.number(basis.columns);
  write_count(out, basis.groups.size(), "row groups");
  Quantized values;
  for (const RowGroup& group : basis.groups) {
    out.number(group.row_count);
    write_count(out, group.columns.size(), "columns");
    out.numbers(group.columns);
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      values.add_row(group.values.data() + c * group.row_count, group.row_count);
  }
  out.numbers(values.scales);
  out.planes(values.values);
  return out;
}

ByteWriter write_proof(const Proof& proof, const FaceModel& model) {
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
