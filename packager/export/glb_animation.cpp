#include "export/glb_animation.h"

#include "export/socket_transform.h"
#include "export/valid_utf8.h"

namespace fb::tool {

GlbAnimation::GlbAnimation(tinygltf::Model& model, GlbBuffer& buffer, std::size_t frames, double fps)
    : model_(model), buffer_(buffer), frames_(frames), fps_(fps) {}

void GlbAnimation::add_weights(int node, std::span<const float> weights) {
  add_channel(node, "weights", buffer_.vectors(weights, 1, 0));
}

void GlbAnimation::add_frames(int node, std::span<const float> frames, std::size_t index, std::size_t count) {
  std::vector<float> translations, rotations;
  for (std::size_t f = 0; f < frames_; ++f) {
    const SocketTransform transform(frames.subspan(12 * (f * count + index), 12));
    for (const double number : transform.translation) translations.push_back(static_cast<float>(number));
    // q and -q turn the same way: the one closer to the frame before is taken.
    double towards = 0;
    for (std::size_t i = 0; i < 4 && f > 0; ++i) towards += transform.rotation[i] * rotations[4 * (f - 1) + i];
    for (const double number : transform.rotation)
      rotations.push_back(static_cast<float>(towards < 0 ? -number : number));
  }
  add_channel(node, "translation", buffer_.vectors(translations, 3, 0));
  add_channel(node, "rotation", buffer_.vectors(rotations, 4, 0));
}

void GlbAnimation::finish(const std::string& name) {
  if (animation_.channels.empty()) return;
  animation_.name = valid_utf8(name);
  model_.animations.push_back(animation_);
}

void GlbAnimation::add_channel(int node, const char* path, int output) {
  if (times_ < 0) {
    std::vector<float> times;
    for (std::size_t f = 0; f < frames_; ++f) times.push_back(static_cast<float>(double(f) / fps_));
    times_ = buffer_.vectors(times, 1, 0);
  }
  tinygltf::AnimationSampler sampler;
  sampler.input = times_;
  sampler.output = output;
  sampler.interpolation = "LINEAR";
  tinygltf::AnimationChannel channel;
  channel.sampler = static_cast<int>(animation_.samplers.size());
  channel.target_node = node;
  channel.target_path = path;
  animation_.samplers.push_back(sampler);
  animation_.channels.push_back(channel);
}

}  // namespace fb::tool
