#include "bake/rig/carried_numbers.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"

namespace fb::bake {
namespace {

// Of the diagonal. Large motions of a face are about half as long, so that channels weigh more than a vertex, and what
// is a tolerable error of a vertex over the diagonal is eight times as much of a channel over its range.
constexpr double range_length = 0.125;

std::size_t channel_coordinates(const RigSchema& schema) {
  return (schema.channels.size() + 2) / 3 * 3;
}

}  // namespace

void add_channel_vertices(RigSchema& schema, Mesh& rest) {
  const double length = range_length * rest.diagonal();
  for (Channel& channel : schema.channels)
    channel.scale = static_cast<float>((double(channel.maximum) - channel.minimum) / length);
  rest.carrier_vertices = checked_u32(channel_coordinates(schema) / 3, "channels");
  rest.points.resize(rest.points.size() + channel_coordinates(schema));
}

std::size_t carried_count(const RigSchema& schema, const Mesh& rest) {
  return schema.channels.size() + rest.driven.scales.size();
}

void join_carried(const RigSchema& schema, const Mesh& rest, std::span<const float> positions,
                  std::span<const float> numbers, std::size_t poses, std::span<float> points) {
  const std::size_t width = rest.points.size(), surface = 3 * rest.surface_vertex_count();
  const std::size_t channels = schema.channels.size(), joints = rest.driven.scales.size(),
                    first_joint = rest.first_joint_coordinate();
  for (std::size_t p = 0; p < poses; ++p) {
    const std::span<float> pose = points.subspan(p * width, width);
    std::ranges::copy(positions.subspan(p * surface, surface), pose.begin());
    std::ranges::fill(pose.subspan(surface), 0.0f);
    const float* const values = numbers.data() + p * (channels + joints);
    for (std::size_t c = 0; c < channels; ++c) {
      const Channel& channel = schema.channels[c];
      const float value = values[c];
      const float within = std::isfinite(value) ? std::clamp(value, channel.minimum, channel.maximum) : value;
      pose[surface + c] = static_cast<float>((double(within) - channel.rest) / channel.scale);
    }
    for (std::size_t n = 0; n < joints; ++n)
      pose[first_joint + n] = static_cast<float>(double(values[channels + n]) / rest.driven.scales[n]);
  }
}

void split_carried(const RigSchema& schema, const Mesh& rest, std::span<const float> points, std::size_t poses,
                   std::span<float> positions, std::span<float> numbers) {
  const std::size_t width = rest.points.size(), surface = 3 * rest.surface_vertex_count();
  const std::size_t channels = schema.channels.size(), joints = rest.driven.scales.size(),
                    first_joint = rest.first_joint_coordinate();
  for (std::size_t p = 0; p < poses; ++p) {
    const std::span<const float> pose = points.subspan(p * width, width);
    std::ranges::copy(pose.first(surface), positions.begin() + std::ptrdiff_t(p * surface));
    float* const values = numbers.data() + p * (channels + joints);
    for (std::size_t c = 0; c < channels; ++c) values[c] = schema.channels[c].value(pose[surface + c]);
    for (std::size_t n = 0; n < joints; ++n) values[channels + n] = rest.driven.scales[n] * pose[first_joint + n];
  }
}

}  // namespace fb::bake
