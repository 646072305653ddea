#include "bake/rig/channel_points.h"

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
  rest.channel_vertices = checked_u32(channel_coordinates(schema) / 3, "channels");
  rest.points.resize(rest.points.size() + channel_coordinates(schema));
}

void join_channels(const RigSchema& schema, std::span<const float> positions, std::span<const float> channels,
                   std::size_t poses, std::span<float> points) {
  const std::size_t width = poses == 0 ? 0 : points.size() / poses, surface = width - channel_coordinates(schema);
  for (std::size_t p = 0; p < poses; ++p) {
    const auto end = std::copy_n(positions.begin() + std::ptrdiff_t(p * surface), surface,
                                 points.begin() + std::ptrdiff_t(p * width));
    std::fill(end, points.begin() + std::ptrdiff_t((p + 1) * width), 0.0f);
    for (std::size_t c = 0; c < schema.channels.size(); ++c) {
      const Channel& channel = schema.channels[c];
      const float value = channels[p * schema.channels.size() + c];
      const float within = std::isfinite(value) ? std::clamp(value, channel.minimum, channel.maximum) : value;
      end[std::ptrdiff_t(c)] = static_cast<float>((double(within) - channel.rest) / channel.scale);
    }
  }
}

void split_channels(const RigSchema& schema, std::span<const float> points, std::size_t poses,
                    std::span<float> positions, std::span<float> channels) {
  const std::size_t width = poses == 0 ? 0 : points.size() / poses, surface = width - channel_coordinates(schema);
  for (std::size_t p = 0; p < poses; ++p) {
    const std::span<const float> pose = points.subspan(p * width, width);
    std::ranges::copy(pose.first(surface), positions.begin() + std::ptrdiff_t(p * surface));
    for (std::size_t c = 0; c < schema.channels.size(); ++c)
      channels[p * schema.channels.size() + c] = schema.channels[c].value(pose[surface + c]);
  }
}

}  // namespace fb::bake
