#include "archive/section_reader.h"

#include <algorithm>
#include <cmath>

namespace fb::archive {
namespace {

Feature read_feature(ByteReader& in) {
  Feature feature;
  feature.kind = static_cast<Feature::Kind>(in.number<std::uint8_t>("a feature's kind"));
  if (feature.kind > Feature::Kind::minimum)
    fail(Status::unsupported, "%s has a feature of unknown kind %u", in.where().c_str(),
         static_cast<unsigned>(feature.kind));
  if (feature.of_features()) {
    feature.first = in.number<std::uint32_t>("a feature's operands");
    feature.second = in.number<std::uint32_t>("a feature's operands");
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
  if (flags & ~(layer_skip_flag | layer_16_bit_flag))
    fail(Status::unsupported, "%s has a layer of unknown flags 0x%x", in.where().c_str(), flags);
  layer.skip = flags & layer_skip_flag;
  layer.wide = flags & layer_16_bit_flag;
  layer.bias = in.float_planes(layer.outputs, "biases");
  layer.scales = in.float_planes(layer.outputs, "weight scales");
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
  if (definition.vertices > max_vertices) in.corrupt("more vertices than the format allows");
  const std::uint32_t controls = in.count(20, "controls");
  in.budget().resize(schema.controls, controls, "controls");
  for (Control& control : schema.controls) {
    control.name = in.string("a control's name");
    control.group = in.string("a control's group");
    control.minimum = in.number<float>("a control's minimum");
    control.maximum = in.number<float>("a control's maximum");
    control.rest = in.number<float>("a control's rest value");
  }
  in.end();
  return definition;
}

void read_network(ByteReader& in, PackedModel& model) {
  const std::uint32_t features = in.count(9, "features");
  in.budget().reserve(model.features, features, "features");
  for (std::uint32_t f = 0; f < features; ++f) model.features.push_back(read_feature(in));
  model.direct = in.numbers<std::uint32_t>(in.count(4, "direct coefficients"), "direct coefficients");
  const std::uint32_t regions = in.count(20, "regions");
  in.budget().resize(model.regions, regions, "regions");
  for (PackedRegion& region : model.regions) {
    region.name = in.string("a region's name");
    region.features = in.numbers<std::uint32_t>(in.count(4, "region features"), "region features");
    region.gate.features = in.numbers<std::uint32_t>(in.count(4, "gate features"), "gate features");
    region.gate.slope = in.number<float>("a gate's slope");
    const std::uint32_t layers = in.count(18, "layers");
    in.budget().reserve(region.layers, layers, "layers");
    for (std::uint32_t l = 0; l < layers; ++l) region.layers.push_back(read_layer(in));
  }
  in.end();
}

Proof read_proof(ByteReader& in, const RigSchema& schema, std::uint32_t vertices, const ProofSizes& sizes) {
  Proof proof;
  const auto poses = in.number<std::uint32_t>("the number of poses");
  proof.controls =
      in.numbers<float>(checked_multiply(poses, schema.control_count(), "proof controls"), "proof controls");
  if (std::any_of(proof.controls.begin(), proof.controls.end(), [](float c) { return std::isnan(c); }))
    in.corrupt("the proof has a control that is not a number");
  proof.hashes = in.numbers<std::uint64_t>(poses, "proof hashes");
  proof.vertices = in.numbers<std::uint32_t>(in.count(4, "proof vertices"), "proof vertices");
  for (const std::uint32_t vertex : proof.vertices)
    if (vertex >= vertices) in.corrupt("the proof names a vertex that does not exist");
  proof.positions =
      in.numbers<float>(checked_multiply(poses, checked_multiply(proof.vertices.size(), 3, "proof"), "proof positions"),
                        "proof positions");
  proof.frames = in.numbers<float>(
      checked_multiply(poses, checked_multiply(sizes.sockets, 12, "proof"), "proof frames"), "proof frames");
  proof.channels =
      in.numbers<float>(checked_multiply(poses, schema.channels.size(), "proof channels"), "proof channels");
  proof.errors = in.numbers<float>(checked_multiply(poses, sizes.errors, "proof errors"), "proof errors");
  if (sizes.errors > 0) proof.outside = in.numbers<std::uint32_t>(poses, "proof errors");
  proof.level_hashes =
      in.numbers<std::uint64_t>(checked_multiply(poses, 2 * sizes.levels, "proof hashes"), "proof hashes of levels");
  if (sizes.driven) proof.joint_hashes = in.numbers<std::uint64_t>(poses, "proof hashes of joints");
  in.end();
  return proof;
}

std::string read_text(ByteReader& in) {
  const auto bytes = in.take(in.left(), "text");
  in.budget().take_text(bytes.size(), "text");
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.find('\0') != std::string::npos) in.corrupt("a text holds a zero byte");
  return text;
}

}  // namespace fb::archive
