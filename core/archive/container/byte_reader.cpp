#include "archive/container/byte_reader.h"

#include <type_traits>

#include "archive/container/container_layout.h"

namespace fb::archive {
namespace {

// `count` zeros: charged for good, or in memory of the budget.
template <class Vector>
Vector zeros(MemoryBudget& budget, std::uint64_t count, const char* what) {
  if constexpr (std::is_constructible_v<Vector, std::pmr::memory_resource*>) {
    return Vector(static_cast<std::size_t>(count), &budget);
  } else {
    Vector values;
    budget.resize(values, count, what);
    return values;
  }
}

}  // namespace

std::string ByteReader::string(const char* what) {
  const auto length = number<std::uint32_t>(what);
  if (length > max_string_bytes) corrupt("a string is longer than the format allows");
  const auto bytes = take(length, what);
  budget_.take_text(length, what);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.find('\0') != std::string::npos) corrupt("a string holds a zero byte");
  return text;
}

template <class Vector>
Vector ByteReader::read_planes(std::uint64_t count, const char* what) {
  const auto bytes = take(checked_multiply(count, 4, where_.c_str()), what);
  Vector values = zeros<Vector>(budget_, count, what);
  const std::size_t plane = values.size();
  for (std::size_t i = 0; i < plane; ++i) {
    std::uint32_t bits = 0;
    for (std::size_t b = 0; b < 4; ++b) bits |= static_cast<std::uint32_t>(bytes[b * plane + i]) << (8 * b);
    values[i] = std::bit_cast<typename Vector::value_type>(bits);
  }
  return values;
}

template std::vector<std::uint32_t> ByteReader::read_planes(std::uint64_t, const char*);
template std::vector<float> ByteReader::read_planes(std::uint64_t, const char*);
template std::pmr::vector<std::uint32_t> ByteReader::read_planes(std::uint64_t, const char*);
template std::pmr::vector<float> ByteReader::read_planes(std::uint64_t, const char*);

}  // namespace fb::archive
