#include "view/npy_bytes.h"

#include "base/status.h"

namespace fb::tool {
namespace {

constexpr std::size_t alignment = 64;  // of the values in the file, as NumPy writes them
constexpr std::size_t fixed_bytes = 10;

}  // namespace

std::string npy_header(const std::vector<std::size_t>& shape) {
  std::string sides;
  for (const std::size_t side : shape) sides += format("%zu, ", side);
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + sides + "), }";
  header.append(alignment - (fixed_bytes + header.size() + 1) % alignment, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size() & 0xff);
  bytes += static_cast<char>(header.size() >> 8);
  bytes += header;
  return bytes;
}

std::string npy_bytes(std::span<const float> values, const std::vector<std::size_t>& shape) {
  std::string bytes = npy_header(shape);
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  return bytes;
}

}  // namespace fb::tool
