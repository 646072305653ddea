// Little-endian writing, the counterpart of byte_reader.h.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "archive/container/container_layout.h"
#include "base/checked.h"
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
  // Fails with `limit`, naming `what`, if the count exceeds 32 bits.
  void count(std::size_t count, const char* what) { number(checked_u32(count, what)); }
  void raw(std::span<const std::byte> more) {
    const std::size_t end = bytes.size();
    bytes.resize(end + more.size());
    std::copy(more.begin(), more.end(), bytes.begin() + end);
  }

  // Length and text. Fails, naming `what`, if the text is too long or holds a zero byte.
  void string(std::string_view text, const char* what) {
    if (text.size() > max_string_bytes)
      fail(Status::limit, "%s is %zu bytes long; an archive holds %u", what, text.size(), max_string_bytes);
    if (text.find('\0') != std::string_view::npos) fail(Status::bad_data, "%s holds a zero byte", what);
    number(static_cast<std::uint32_t>(text.size()));
    raw(std::as_bytes(std::span(text)));
  }
  // Four byte planes, the least significant first: small or similar numbers compress well so.
  void planes(const std::vector<std::uint32_t>& values) {
    for (std::size_t plane = 0; plane < sizeof(std::uint32_t); ++plane)
      for (const std::uint32_t value : values) bytes.push_back(static_cast<std::byte>(value >> (8 * plane)));
  }
  void float_planes(const std::vector<float>& values) {
    std::vector<std::uint32_t> bits;
    for (const float value : values) bits.push_back(std::bit_cast<std::uint32_t>(value));
    planes(bits);
  }
};

}  // namespace fb::archive
