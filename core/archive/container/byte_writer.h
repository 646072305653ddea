// Little-endian writing, the counterpart of byte_reader.h.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "archive/container/layout.h"
#include "base/status.h"

namespace fb::archive {

class ByteWriter {
 public:
  std::vector<std::byte> bytes;

  template <class T>
  void number(T value) {
    auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
    this->raw(raw);
  }
  template <class T>
  void numbers(const std::vector<T>& values) {
    for (const T value : values) number(value);
  }
  void raw(std::span<const std::byte> more) {
    const std::size_t end = bytes.size();
    bytes.resize(end + more.size());
    std::copy(more.begin(), more.end(), bytes.begin() + end);
  }

  // Length and text; fails, naming `what`, if it is too long or holds a zero byte.
  void string(std::string_view text, const char* what) {
    if (text.size() > max_string_bytes)
      fail(Status::limit, "%s is %zu bytes long; an archive holds %u", what, text.size(), max_string_bytes);
    if (text.find('\0') != std::string_view::npos) fail(Status::bad_data, "%s holds a zero byte", what);
    number(static_cast<std::uint32_t>(text.size()));
    raw(std::as_bytes(std::span(text)));
  }
  // All least significant bytes, then all the next: what compresses well of numbers that are small or alike.
  template <class T>
  void planes(const std::vector<T>& values) {
    for (std::size_t plane = 0; plane < sizeof(T); ++plane)
      for (const T value : values)
        bytes.push_back(static_cast<std::byte>(static_cast<std::make_unsigned_t<T>>(value) >> (8 * plane)));
  }
  void planes(const std::vector<float>& values) {
    std::vector<std::uint32_t> bits;
    for (const float value : values) bits.push_back(std::bit_cast<std::uint32_t>(value));
    planes(bits);
  }
  // Planes of 16 bits where `wide`, else one byte each.
  void whole_numbers(const std::vector<std::int16_t>& values, bool wide) {
    if (wide) return planes(values);
    for (const std::int16_t value : values) number(static_cast<std::int8_t>(value));
  }
};

}  // namespace fb::archive
