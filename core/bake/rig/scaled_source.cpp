#include "bake/rig/scaled_source.h"

#include <cmath>
#include <utility>

namespace fb::bake {
namespace {

void scale(std::span<float> values, int exponent) {
  for (float& value : values) value = std::ldexp(value, exponent);
}

}  // namespace

Mesh scaled(Mesh mesh, int exponent) {
  scale(mesh.points, exponent);
  return mesh;
}

PackedModel scaled(PackedModel face, int exponent) {
  scale(face.rest.points, exponent);
  for (PackedRowBlock& block : face.row_blocks)
    for (PackedColumn& column : block.columns) column.scale = std::ldexp(column.scale, exponent);
  return face;
}

ScaledSource::ScaledSource(Source& source, int exponent)
    : source_(source), exponent_(exponent), rest_(scaled(source.rest(), exponent)) {}

ScaledSource::ScaledSource(std::unique_ptr<Source> source, int exponent)
    : owned_(std::move(source)), source_(*owned_), exponent_(exponent), rest_(scaled(source_.rest(), exponent)) {}

void ScaledSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  source_.read(clip, first, count, points);
  scale(points, exponent_);
}

void ScaledSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  source_.evaluate(controls, count, points);
  scale(points, exponent_);
}

}  // namespace fb::bake
