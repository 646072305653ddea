// What channels of animations move.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace tinygltf {
struct AnimationChannel;
}  // namespace tinygltf

namespace fb::bake {

struct AnimationTarget {
  std::string path;                   // "weights", "translation", "rotation", "scale"; others are not read
  int node = -1;                      // -1: none
  int mesh = -1;                      // whose weights move wherever it is shown; -1: the node's
  std::optional<std::size_t> weight;  // that one alone

  bool moves_node() const { return path == "translation" || path == "rotation" || path == "scale"; }
};

// What a channel says, by itself or by KHR_animation_pointer, of whose pointers these are read: /nodes/N/weights,
// /nodes/N/weights/I, /meshes/N/weights, /meshes/N/weights/I, /nodes/N/translation, rotation and scale. Of others the
// path is the pointer.
AnimationTarget target_of(const tinygltf::AnimationChannel& channel);

}  // namespace fb::bake
