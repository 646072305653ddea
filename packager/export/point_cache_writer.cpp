#include "export/point_cache_writer.h"

#include <bit>
#include <cstdint>
#include <vector>

#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {
namespace {

static_assert(std::endian::native == std::endian::little,
              "caches are written in the byte order of memory, or the other");

std::uint32_t swapped(std::uint32_t number) {
  return __builtin_bswap32(number);
}

}  // namespace

PointCacheWriter::PointCacheWriter(const std::filesystem::path& path, PointCache kind, std::size_t frames,
                                   std::size_t points, double fps)
    : file_(path), kind_(kind) {
  if (frames > INT32_MAX || points > INT32_MAX)
    fail(Status::limit, "%s: %zu frames of %zu points are more than a point cache counts", shown(path).c_str(), frames,
         points);
  const auto counted = [](std::size_t count) { return static_cast<std::uint32_t>(count); };
  std::vector<std::uint32_t> header;
  if (kind == PointCache::mdd) {
    header = {swapped(counted(frames)), swapped(counted(points))};
    for (std::size_t f = 0; f < frames; ++f)
      header.push_back(swapped(std::bit_cast<std::uint32_t>(static_cast<float>(double(f) / fps))));
  } else {
    file_.write(std::as_bytes(std::span("POINTCACHE2")));  // with its zero
    constexpr std::uint32_t version = 1;
    header = {version, counted(points), std::bit_cast<std::uint32_t>(0.0f), std::bit_cast<std::uint32_t>(1.0f),
              counted(frames)};
  }
  file_.write(std::as_bytes(std::span(header)));
}

void PointCacheWriter::add(std::span<const float> positions) {
  if (kind_ == PointCache::pc2) return file_.write(std::as_bytes(positions));
  std::vector<std::uint32_t> big;
  big.reserve(positions.size());
  for (const float number : positions) big.push_back(swapped(std::bit_cast<std::uint32_t>(number)));
  file_.write(std::as_bytes(std::span(big)));
}

}  // namespace fb::tool
