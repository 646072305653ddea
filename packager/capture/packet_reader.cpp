#include "capture/packet_reader.h"

#include <bit>
#include <cmath>

#include "base/status.h"
#include "base/utf8.h"

namespace fb::tool {

std::span<const std::byte> PacketReader::take(std::size_t size, const char* what) {
  if (size > left())
    fail(Status::bad_data, "byte %zu: %s has %zu bytes where %zu are left", offset_, what, size, left());
  const auto part = bytes_.subspan(offset_, size);
  offset_ += size;
  return part;
}

std::uint32_t PacketReader::word(const char* what) {
  std::uint32_t value = 0;
  for (const std::byte byte : take(4, what)) value = value << 8 | std::to_integer<std::uint32_t>(byte);
  return value;
}

float PacketReader::number(const char* what) {
  const std::size_t start = offset_;
  const auto value = std::bit_cast<float>(word(what));
  if (!std::isfinite(value)) fail(Status::not_finite, "byte %zu: %s is no finite number", start, what);
  return value;
}

std::string_view PacketReader::text(std::size_t size, const char* what) {
  const std::size_t start = offset_;
  const auto part = take(size, what);
  const std::string_view text(reinterpret_cast<const char*>(part.data()), part.size());
  if (find_utf8_fault(text)) fail(Status::bad_data, "byte %zu: %s is no UTF-8 text", start, what);
  return text;
}

}  // namespace fb::tool
