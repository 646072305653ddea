// Packets of capture programs, built byte by byte as their formats are documented, and a face for them.
#pragma once

#include <facebaker/facebaker.h>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace capture_packets {

using Bytes = std::vector<std::byte>;

inline void add_word(Bytes& bytes, std::uint32_t word) {
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::byte>(word >> shift & 0xff));
}

inline void add_float(Bytes& bytes, float value) {
  add_word(bytes, std::bit_cast<std::uint32_t>(value));
}

inline void add_letters(Bytes& bytes, std::string_view letters) {
  for (const char letter : letters) bytes.push_back(static_cast<std::byte>(letter));
}

inline void add_bytes(Bytes& bytes, const Bytes& more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

inline constexpr std::string_view device = "01234567-89AB-CDEF-0123-456789ABCDEF";

// A packet of Live Link Face without its values, as it comes where there is no face.
inline Bytes live_link_head(std::string_view subject) {
  Bytes bytes = {std::byte{6}};
  add_word(bytes, static_cast<std::uint32_t>(device.size()));
  add_letters(bytes, device);
  add_word(bytes, static_cast<std::uint32_t>(subject.size()));
  add_letters(bytes, subject);
  add_word(bytes, 123456);  // frame
  add_float(bytes, 0.25F);  // of a frame
  add_word(bytes, 60);      // frames
  add_word(bytes, 1);       // in a second
  return bytes;
}

inline Bytes live_link_packet(const std::array<float, 61>& values, std::string_view subject = "iPhone") {
  Bytes bytes = live_link_head(subject);
  bytes.push_back(std::byte{61});
  for (const float value : values) add_float(bytes, value);
  return bytes;
}

// A text of OSC: a zero ends it, and more fill a word.
inline void add_osc_text(Bytes& bytes, std::string_view text) {
  add_letters(bytes, text);
  do bytes.push_back(std::byte{0});
  while (bytes.size() % 4 != 0);
}

inline Bytes osc_message(std::string_view address, std::string_view types) {
  Bytes bytes;
  add_osc_text(bytes, address);
  add_osc_text(bytes, "," + std::string(types));
  return bytes;
}

inline Bytes blend_value(std::string_view name, float value) {
  Bytes bytes = osc_message("/VMC/Ext/Blend/Val", "sf");
  add_osc_text(bytes, name);
  add_float(bytes, value);
  return bytes;
}

inline Bytes blend_apply() {
  return osc_message("/VMC/Ext/Blend/Apply", "");
}

inline Bytes osc_bundle(const std::vector<Bytes>& elements) {
  Bytes bytes;
  add_letters(bytes, std::string_view("#bundle\0", 8));
  add_word(bytes, 0);
  add_word(bytes, 1);  // at once
  for (const Bytes& element : elements) {
    add_word(bytes, static_cast<std::uint32_t>(element.size()));
    add_bytes(bytes, element);
  }
  return bytes;
}

inline fb_control control(const char* name, const char* arkit = "", float least = 0, float most = 1, float rest = 0,
                          const char* unit = "") {
  fb_control made = {};
  made.struct_size = sizeof made;
  made.name = name;
  made.group = "";
  made.minimum = least;
  made.maximum = most;
  made.rest = rest;
  made.mirror = FB_NO_CONTROL;
  made.arkit = arkit;
  made.facs = "";
  made.unit = unit;
  return made;
}

// Controls with ARKit names as labels and as their own, with VRM's names of both versions, and with a unit.
inline std::vector<fb_control> face_controls() {
  return {control("jaw", "jawOpen", 0, 30, 0, "degrees"),
          control("EyeBlink_L"),
          control("happy"),
          control("A"),
          control("brow", "", -1, 1),
          control("headYaw", "", -0.5F, 0.5F)};
}

}  // namespace capture_packets
