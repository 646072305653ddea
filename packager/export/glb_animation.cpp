#include "export/glb_animation.h"

#include "export/valid_utf8.h"

namespace fb::tool {

GlbAnimation::GlbAnimation(tinygltf::Model& model, GlbBuffer& buffer, std::size_t frames, double fps)
    : model_(model), buffer_(buffer), frames_(frames), fps_(fps) {}

void GlbAnimation::add_weights(int node, std::span<const float> weights) {
  add_channels({&node, 1}, "weights", weights, 1);
}

void GlbAnimation::add_frames(int node, std::span<const float> frames, std::size_t index, std::size_t count) {
  NodeTrack track;
  for (std::size_t f = 0; f < frames_; ++f) {
    const NodeTransform transform(frames.subspan(12 * (f * count + index), 12));
    for (const double number : transform.translation) track.translations.push_back(static_cast<float>(number));
    track.add_rotation(transform.rotation);
  }
  add_track({&node, 1}, track);
}

void GlbAnimation::add_track(std::span<const int> nodes, const NodeTrack& track) {
  add_channels(nodes, "translation", track.translations, 3);
  add_channels(nodes, "rotation", track.rotations, 4);
  add_channels(nodes, "scale", track.scales, 3);
}

void GlbAnimation::finish(const std::string& name) {
  if (animation_.channels.empty()) return;
  animation_.name = valid_utf8(name);
  model_.animations.push_back(animation_);
}

void GlbAnimation::add_channels(std::span<const int> nodes, const char* path, std::span<const float> values,
                                int width) {
  if (values.empty()) return;
  const int output = buffer_.vectors(values, width, 0);
  if (times_ < 0) {
    std::vector<float> times;
    for (std::size_t f = 0; f < frames_; ++f) times.push_back(static_cast<float>(double(f) / fps_));
    times_ = buffer_.vectors(times, 1, 0);
  }
  tinygltf::AnimationSampler sampler;
  sampler.input = times_;
  sampler.output = output;
  sampler.interpolation = "LINEAR";
  for (const int node : nodes) {
    tinygltf::AnimationChannel channel;
    channel.sampler = static_cast<int>(animation_.samplers.size());
    channel.target_node = node;
    channel.target_path = path;
    animation_.channels.push_back(channel);
  }
  animation_.samplers.push_back(sampler);
}

}  // namespace fb::tool
