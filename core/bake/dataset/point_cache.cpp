#include "bake/dataset/point_cache.h"

#include <array>
#include <bit>
#include <cstring>

#include "base/checked.h"
#include "base/input_file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

static_assert(std::endian::native == std::endian::little, "caches are read in the byte order of memory, or the other");

constexpr char pc2_mark[12] = "POINTCACHE2";
constexpr std::size_t pc2_header = 32;

template <std::size_t size>
std::array<std::byte, size> read_header(const std::filesystem::path& path, const char* kind) {
  std::array<std::byte, size> bytes = {};
  if (InputFile(path).read_at(0, bytes) != size)
    fail(Status::bad_data, "%s: is no %s file: it has no whole header", shown(path).c_str(), kind);
  return bytes;
}

std::uint32_t little(const std::byte* bytes) {
  std::uint32_t value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::uint32_t big(const std::byte* bytes) {
  return __builtin_bswap32(little(bytes));
}

// A count of a header, where it is an int32.
std::size_t positive(std::uint32_t count, const char* what, const std::filesystem::path& path) {
  if (count == 0 || count > INT32_MAX)
    fail(Status::bad_data, "%s: its header says %d %s", shown(path).c_str(), static_cast<std::int32_t>(count), what);
  return count;
}

}  // namespace

MddFile::MddFile(std::filesystem::path file) : ArrayFile(std::move(file)) {
  const auto header = read_header<8>(path(), "MDD");
  const std::size_t frames = positive(big(&header[0]), "frames", path()),
                    points = positive(big(&header[4]), "points", path());
  set_shape({frames, points, 3}, checked_add(8, checked_multiply(frames, 4, "times"), "times"), 4);
}

void MddFile::read_rows(std::size_t first, std::span<float> values) const {
  read_bytes(first, std::as_writable_bytes(values));
  for (float& value : values) value = std::bit_cast<float>(__builtin_bswap32(std::bit_cast<std::uint32_t>(value)));
}

Pc2File::Pc2File(std::filesystem::path file) : ArrayFile(std::move(file)) {
  const auto header = read_header<pc2_header>(path(), "PC2");
  if (std::memcmp(header.data(), pc2_mark, sizeof pc2_mark) != 0)
    fail(Status::bad_data, "%s: is no PC2 file: it does not begin with %s", shown(path()).c_str(), pc2_mark);
  if (const std::uint32_t version = little(&header[12]); version != 1)
    fail(Status::unsupported, "%s: PC2 version %u; 1 is read", shown(path()).c_str(), version);
  const std::size_t points = positive(little(&header[16]), "points", path()),
                    samples = positive(little(&header[28]), "samples", path());
  set_shape({samples, points, 3}, pc2_header, 4);
}

void Pc2File::read_rows(std::size_t first, std::span<float> values) const {
  read_bytes(first, std::as_writable_bytes(values));
}

}  // namespace fb::bake
