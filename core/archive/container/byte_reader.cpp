#include "archive/container/byte_reader.h"

#include "archive/container/container_layout.h"

namespace fb::archive {

std::string ByteReader::string(const char* what) {
  const auto length = number<std::uint32_t>(what);
  if (length > max_string_bytes) corrupt("a string is longer than the format allows");
  const auto bytes = take(length, what);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.find('\0') != std::string::npos) corrupt("a string holds a zero byte");
  return text;
}

std::vector<std::uint32_t> ByteReader::planes(std::uint64_t count, const char* what) {
  const auto bytes = take(checked_multiply(count, 4, where_.c_str()), what);
  budget_.take(count, sizeof(std::uint32_t), what);
  std::vector<std::uint32_t> values(static_cast<std::size_t>(count));
  for (std::size_t plane = 0; plane < 4; ++plane)
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] |= static_cast<std::uint32_t>(bytes[plane * values.size() + i]) << (8 * plane);
  return values;
}

std::vector<float> ByteReader::float_planes(std::uint64_t count, const char* what) {
  const std::vector<std::uint32_t> bits = planes(count, what);
  std::vector<float> values;
  values.reserve(bits.size());
  for (const std::uint32_t number : bits) values.push_back(std::bit_cast<float>(number));
  return values;
}

}  // namespace fb::archive
