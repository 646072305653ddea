#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace fb::tool {

// Reads the numbers and texts of a packet from its first byte on, big-endian. Fails with bad_data, naming the byte
// offset, where the packet ends before them: nothing beyond its end is read.
class PacketReader {
 public:
  explicit PacketReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::size_t offset() const { return offset_; }
  std::size_t left() const { return bytes_.size() - offset_; }

  std::uint8_t byte(const char* what) { return std::to_integer<std::uint8_t>(take(1, what)[0]); }
  std::uint32_t word(const char* what);
  // Fails with not_finite on NaN and infinity.
  float number(const char* what);
  // A view into the packet. Fails where it is not UTF-8, or has a zero.
  std::string_view text(std::size_t size, const char* what);
  std::span<const std::byte> take(std::size_t size, const char* what);

 private:
  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
};

}  // namespace fb::tool
