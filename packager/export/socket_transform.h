#pragma once

#include <array>
#include <span>

namespace fb::tool {

// A frame of facebaker_character.h as glTF has it: first scaled, then turned, then moved.
struct SocketTransform {
  std::array<double, 3> translation;
  std::array<double, 4> rotation;  // unit quaternion: x, y, z, w
  std::array<double, 3> scale;     // below 0 along x where the frame mirrors
  bool sheared = false;            // its axes are not at right angles, which glTF cannot say: they are put so

  // frame: 12 floats, rows of a 3 x 4 matrix.
  explicit SocketTransform(std::span<const float> frame);
};

}  // namespace fb::tool
