#include "archive/section_writer.h"

#include "archive/section_reader.h"

namespace fb::archive {
namespace {

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
  out.count(list.size(), what);
  out.numbers(list);
}

void write_layer(ByteWriter& out, const PackedLayer& layer) {
  out.number(layer.inputs);
  out.number(layer.outputs);
  out.number(static_cast<std::uint8_t>(layer.activation));
  out.number(static_cast<std::uint8_t>((layer.skip ? layer_skip_flag : 0) | (layer.wide ? layer_16_bit_flag : 0)));
  out.float_planes(layer.bias);
  out.float_planes(layer.scales);
}

}  // namespace

ByteWriter write_definition(const PackedModel& model) {
  const RigSchema& schema = model.schema;
  ByteWriter out;
  out.string(schema.name, "the rig's name");
  out.string(schema.units, "the units");
  out.string(schema.up_axis, "the up axis");
  const std::size_t vertices = model.rest.surface_vertex_count();
  if (vertices > max_vertices) fail(Status::limit, "%zu vertices; an archive holds %u", vertices, max_vertices);
  out.count(vertices, "vertices");
  out.count(schema.control_count(), "controls");
  for (const Control& control : schema.controls) {
    out.string(control.name, "a control's name");
    out.string(control.group, "a control's group");
    out.number(control.minimum);
    out.number(control.maximum);
    out.number(control.rest);
  }
  return out;
}

ByteWriter write_network(const PackedModel& model) {
  ByteWriter out;
  out.count(model.features.size(), "features");
  for (const Feature& feature : model.features) write_feature(out, feature);
  write_list(out, model.direct, "direct coefficients");
  out.count(model.regions.size(), "regions");
  for (const PackedRegion& region : model.regions) {
    out.string(region.name, "a region's name");
    write_list(out, region.features, "region features");
    write_list(out, region.gate.features, "gate features");
    out.number(region.gate.slope);
    out.count(region.layers.size(), "layers");
    for (const PackedLayer& layer : region.layers) write_layer(out, layer);
  }
  return out;
}

ByteWriter write_proof(const Proof& proof, const PackedModel& model) {
  const std::size_t controls = model.schema.control_count(), poses = proof.hashes.size();
  if (proof.controls.size() != poses * controls || proof.positions.size() != poses * proof.vertices.size() * 3)
    fail(Status::bad_data,
         "the proof has %zu hashes, %zu control values and %zu coordinates for %zu controls and %zu "
         "vertices",
         poses, proof.controls.size(), proof.positions.size(), controls, proof.vertices.size());
  if (proof.frames.size() != poses * model.character.sockets.size() * 12)
    fail(Status::bad_data, "the proof has %zu numbers of frames for %zu poses of %zu sockets", proof.frames.size(),
         poses, model.character.sockets.size());
  if (proof.channels.size() != poses * model.schema.channels.size())
    fail(Status::bad_data, "the proof has %zu values for %zu poses of %zu channels", proof.channels.size(), poses,
         model.schema.channels.size());
  const std::size_t errors = model.expected.count();
  if (proof.errors.size() != poses * errors || proof.outside.size() != (errors > 0 ? poses : 0))
    fail(Status::bad_data, "the proof has %zu expected errors for %zu poses of %zu", proof.errors.size(), poses,
         errors);
  if (proof.level_hashes.size() != poses * 2 * model.levels.size())
    fail(Status::bad_data, "the proof has %zu hashes of levels for %zu poses of %zu", proof.level_hashes.size(), poses,
         model.levels.size());
  if (proof.joint_hashes.size() != (model.rest.driven.empty() ? 0 : poses))
    fail(Status::bad_data, "the proof has %zu hashes of driven joints for %zu poses", proof.joint_hashes.size(), poses);
  for (const std::uint32_t vertex : proof.vertices)
    if (vertex >= model.rest.surface_vertex_count())
      fail(Status::bad_data, "the proof names vertex %u of %zu", vertex, model.rest.surface_vertex_count());
  ByteWriter out;
  out.count(poses, "proof poses");
  out.numbers(proof.controls);
  out.numbers(proof.hashes);
  write_list(out, proof.vertices, "proof vertices");
  out.numbers(proof.positions);
  out.numbers(proof.frames);
  out.numbers(proof.channels);
  out.numbers(proof.errors);
  out.numbers(proof.outside);
  out.numbers(proof.level_hashes);
  out.numbers(proof.joint_hashes);
  return out;
}

ByteWriter write_text(const std::string& text, const char* what) {
  if (text.find('\0') != std::string::npos) fail(Status::bad_data, "%s holds a zero byte", what);
  ByteWriter out;
  out.raw(std::as_bytes(std::span(text)));
  return out;
}

}  // namespace fb::archive
