#pragma once

#include <span>
#include <vector>

#include "export/glb_buffer.h"
#include "export/morph_targets.h"
#include "export/node_transform.h"

namespace fb::tool {

// Collects the channels of an animation of a .glb.
class GlbAnimation {
 public:
  // frames: how many, a frame every 1 / fps seconds.
  GlbAnimation(tinygltf::Model& model, GlbBuffer& buffer, std::size_t frames, double fps);

  // The weights of a mesh's targets, frames x targets.
  void add_weights(int node, std::span<const float> weights);
  // The node of a socket or joint, the one at `index` of `count`. frames: frames x count x 12 floats, without scale.
  void add_frames(int node, std::span<const float> frames, std::size_t index, std::size_t count);
  // Nodes that all move in one way.
  void add_track(std::span<const int> nodes, const NodeTrack& track);
  // Adds it to the model, unless it has no channels.
  void finish(const std::string& name);

 private:
  // Of numbers for all frames, `width` a frame; none: no channel.
  void add_channels(std::span<const int> nodes, const char* path, std::span<const float> values, int width);

  tinygltf::Model& model_;
  GlbBuffer& buffer_;
  std::size_t frames_;
  double fps_;
  int times_ = -1;  // accessor, made with the first channel
  tinygltf::Animation animation_;
};

}  // namespace fb::tool
