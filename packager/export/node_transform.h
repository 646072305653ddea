#pragma once

#include <array>
#include <span>
#include <vector>

#include "export/frame_math.h"

namespace fb::tool {

// A frame of facebaker_character.h as a node of glTF has it: first scaled, then turned, then moved.
struct NodeTransform {
  std::array<double, 3> translation;
  std::array<double, 4> rotation;  // unit quaternion: x, y, z, w
  std::array<double, 3> scale;     // below 0 along x where the frame mirrors
  bool sheared = false;            // its axes are not at right angles, which glTF cannot say: they are put so

  // frame: 12 floats, rows of a 3 x 4 matrix.
  explicit NodeTransform(std::span<const float> frame) : NodeTransform(to_frame(frame)) {}
  explicit NodeTransform(const Frame& frame);

  Frame frame() const;
};

// The transforms of a node over time. A part without numbers is as the node has it.
struct NodeTrack {
  std::vector<float> translations, rotations, scales;  // frames x 3, 4 and 3

  // q and -q turn the same way: the one closer to the frame before is taken.
  void add_rotation(const std::array<double, 4>& rotation);
  bool empty() const { return translations.empty() && rotations.empty() && scales.empty(); }
};

}  // namespace fb::tool
