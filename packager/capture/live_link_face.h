// Packets of Live Link Face, Epic's app for facial capture with a phone, as it sends them to Unreal (the mode "Live
// Link (ARKit)"), one a frame. Their layout is that which PyLiveLinkFace, GodotLiveLinkFace and others read, numbers
// big-endian:
//
//   uint8     version: 6
//   int32, n  length and text of the device's id, a UUID of 36 letters
//   int32, n  length and text of the subject's name, as the app's settings say
//   int32     frame number, float: fraction of a frame, int32: frames, in int32 seconds
//   uint8     count of values: 61; the packet ends before it where the phone sees no face
//   float     61 values: ARKit's 52 face blendshapes from 0 to 1; yaw, pitch and roll of head, left eye and right eye,
//             where -1 to 1 are -180 to 180 degrees
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace fb::tool {

inline constexpr std::size_t live_link_shapes = 52, live_link_values = 61;

// What the values are, in their order in packets; the turns of head and eyes follow the shapes.
extern const std::array<const char*, live_link_values> live_link_names;

struct LiveLinkFacePacket {
  std::string_view device, subject;  // in the packet
  bool has_face = false;
  std::array<float, live_link_values> values = {};  // finite; zeros without a face
};

// Fails with bad_data or not_finite, naming the byte offset, on what is no such packet.
LiveLinkFacePacket parse_live_link_face(std::span<const std::byte> bytes);

}  // namespace fb::tool
