#include "capture/live_link_face.h"

#include "base/status.h"
#include "capture/packet_reader.h"

namespace fb::tool {
namespace {

constexpr unsigned live_link_version = 6;
constexpr std::size_t longest_subject = 256;  // bytes
constexpr std::size_t frame_time_bytes = 16;

std::string_view read_text(PacketReader& reader, const char* length_name, const char* name) {
  const std::size_t start = reader.offset(), length = reader.word(length_name);
  if (length > longest_subject)
    fail(Status::bad_data, "byte %zu: %s is %zu, and %zu at most", start, length_name, length, longest_subject);
  return reader.text(length, name);
}

}  // namespace

const std::array<const char*, live_link_values> live_link_names = {"eyeBlinkLeft",
                                                                   "eyeLookDownLeft",
                                                                   "eyeLookInLeft",
                                                                   "eyeLookOutLeft",
                                                                   "eyeLookUpLeft",
                                                                   "eyeSquintLeft",
                                                                   "eyeWideLeft",
                                                                   "eyeBlinkRight",
                                                                   "eyeLookDownRight",
                                                                   "eyeLookInRight",
                                                                   "eyeLookOutRight",
                                                                   "eyeLookUpRight",
                                                                   "eyeSquintRight",
                                                                   "eyeWideRight",
                                                                   "jawForward",
                                                                   "jawLeft",
                                                                   "jawRight",
                                                                   "jawOpen",
                                                                   "mouthClose",
                                                                   "mouthFunnel",
                                                                   "mouthPucker",
                                                                   "mouthLeft",
                                                                   "mouthRight",
                                                                   "mouthSmileLeft",
                                                                   "mouthSmileRight",
                                                                   "mouthFrownLeft",
                                                                   "mouthFrownRight",
                                                                   "mouthDimpleLeft",
                                                                   "mouthDimpleRight",
                                                                   "mouthStretchLeft",
                                                                   "mouthStretchRight",
                                                                   "mouthRollLower",
                                                                   "mouthRollUpper",
                                                                   "mouthShrugLower",
                                                                   "mouthShrugUpper",
                                                                   "mouthPressLeft",
                                                                   "mouthPressRight",
                                                                   "mouthLowerDownLeft",
                                                                   "mouthLowerDownRight",
                                                                   "mouthUpperUpLeft",
                                                                   "mouthUpperUpRight",
                                                                   "browDownLeft",
                                                                   "browDownRight",
                                                                   "browInnerUp",
                                                                   "browOuterUpLeft",
                                                                   "browOuterUpRight",
                                                                   "cheekPuff",
                                                                   "cheekSquintLeft",
                                                                   "cheekSquintRight",
                                                                   "noseSneerLeft",
                                                                   "noseSneerRight",
                                                                   "tongueOut",
                                                                   "headYaw",
                                                                   "headPitch",
                                                                   "headRoll",
                                                                   "leftEyeYaw",
                                                                   "leftEyePitch",
                                                                   "leftEyeRoll",
                                                                   "rightEyeYaw",
                                                                   "rightEyePitch",
                                                                   "rightEyeRoll"};

LiveLinkFacePacket parse_live_link_face(std::span<const std::byte> bytes) {
  PacketReader reader(bytes);
  if (const unsigned version = reader.byte("the version"); version != live_link_version)
    fail(Status::bad_data, "byte 0: the version is %u, and Live Link Face sends %u", version, live_link_version);
  LiveLinkFacePacket packet;
  packet.device = read_text(reader, "the length of the device's id", "the device's id");
  packet.subject = read_text(reader, "the length of the subject's name", "the subject's name");
  reader.take(frame_time_bytes, "the frame's time");
  if (reader.left() == 0) return packet;
  const std::size_t start = reader.offset();
  if (const unsigned count = reader.byte("the count of values"); count != live_link_values)
    fail(Status::bad_data, "byte %zu: there are %u values, and %zu expected", start, count, live_link_values);
  for (float& value : packet.values) value = reader.number("a value");
  if (reader.left() > 0)
    fail(Status::bad_data, "byte %zu: %zu bytes follow the last value", reader.offset(), reader.left());
  packet.has_face = true;
  return packet;
}

}  // namespace fb::tool
