#include "archive/byte_reader.h"

#include "archive/layout.h"

namespace fb {

std::string ByteReader::string(const char* what) {
  const auto length = number<std::uint32_t>(what);
  if (length > max_string_bytes) damaged("a string is longer than the format allows");
  const auto bytes = take(length, what);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.find('\0') != std::string::npos) damaged("a string holds a zero byte");
  return text;
}

std::vector<std::uint32_t> ByteReader::planes32(std::uint32_t count, const char* what) {
  const auto bytes = take(std::uint64_t(count) * 4, what);
  budget_.take(count, sizeof(std::uint32_t), what);
  std::vector<std::uint32_t> values(count);
  for (std::size_t plane = 0; plane < 4; ++plane)
    for (std::size_t i = 0; i < count; ++i)
      values[i] |= static_cast<std::uint32_t>(bytes[plane * count + i]) << (8 * plane);
  return values;
}

}  // namespace fb
