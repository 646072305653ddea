#include "bake/rig/scaled_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fb::bake {
namespace {

void scale(std::span<float> values, int exponent) {
  for (float& value : values) value = std::ldexp(value, exponent);
}

}  // namespace

RigSchema scaled(RigSchema schema, int exponent) {
  for (Channel& channel : schema.channels) channel.scale = std::ldexp(channel.scale, -exponent);
  return schema;
}

Mesh scaled(Mesh mesh, int exponent) {
  scale(mesh.points, exponent);
  std::size_t at = 0;
  for (DrivenJoint& joint : mesh.driven.joints) {
    for (const std::size_t origin : {3, 7, 11}) joint.rest[origin] = std::ldexp(joint.rest[origin], exponent);
    // Of the numbers, only those that move a joint are lengths, as the coordinates that carry them are.
    for (const std::uint8_t kind : joint.number_kinds()) {
      float& of = mesh.driven.scales[at++];
      if (!((joint_translation | joint_pivot) >> kind & 1)) of = std::ldexp(of, -exponent);
    }
  }
  return mesh;
}

PackedModel scaled(PackedModel face, int exponent) {
  face.schema = scaled(std::move(face.schema), exponent);
  face.rest = scaled(std::move(face.rest), exponent);
  for (PackedRowBlock& block : face.row_blocks)
    for (PackedColumn& column : block.columns) column.scale = std::ldexp(column.scale, exponent);
  face.expected.unit = std::ldexp(face.expected.unit, exponent);
  for (ExactPose& pose : face.exact) pose.step = std::ldexp(pose.step, exponent);
  return face;
}

ScaledSource::ScaledSource(Source& source, int exponent)
    : ConvertedSource(source), exponent_(exponent), schema_(scaled(source.schema(), exponent)) {
  rest_ = scaled(std::move(rest_), exponent);
}

ScaledSource::ScaledSource(std::unique_ptr<Source> source, int exponent)
    : ConvertedSource(std::move(source)), exponent_(exponent), schema_(scaled(this->source().schema(), exponent)) {
  rest_ = scaled(std::move(rest_), exponent);
}

void ScaledSource::convert(std::span<const float>, std::span<const float> from, std::size_t,
                           std::span<float> to) const {
  std::ranges::copy(from, to.begin());
  scale(to, exponent_);
}

}  // namespace fb::bake
