// What the reader and the writer of the .fbk format share; FORMAT.md says what they mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fb::archive {

inline constexpr unsigned char archive_magic[8] = {0x89, 'F', 'B', 'K', 0x0d, 0x0a, 0x1a, 0x0a};
inline constexpr std::uint16_t archive_major = 1, archive_minor = 0;

inline constexpr std::size_t header_bytes = 24, table_row_bytes = 56, checksum_bytes = 8, section_name_bytes = 16;
inline constexpr std::uint32_t max_sections = 64;
inline constexpr std::uint32_t max_vertices = 0x10000000;  // 3 x vertices and Draco's signed counts stay in range
inline constexpr std::uint32_t max_string_bytes = 0xffff;

inline constexpr std::uint32_t section_required = 1;  // the one flag there is
// zstd was what versions before 1.0 packed with.
enum class Codec : std::uint32_t { none = 0, zstd = 1, deflate = 2 };

inline constexpr std::uint8_t layer_skips = 1, layer_is_wide = 2;      // the flags of a layer
inline constexpr std::uint8_t place_is_wide = 1, place_has_scale = 2;  // the flags of a column in a group

// How the points of section "geometry" find their vertices, and how the corners of section "polygons" are told.
enum class PointOrder : std::uint32_t { as_stored = 0, by_index = 1 };
enum class CornerCoding : std::uint32_t { steps = 0, along_triangles = 1 };
// How the corners of section "uvs" find their texture coordinates.
enum class UvCoding : std::uint32_t { steps = 0, by_vertex = 1 };
inline constexpr std::int32_t most_steps = 0xffffff;  // of a coordinate on a grid: what a float holds exactly

namespace section {
inline constexpr const char* definition = "definition";
inline constexpr const char* polygons = "polygons";
inline constexpr const char* geometry = "geometry";
inline constexpr const char* uvs = "uvs";
inline constexpr const char* network = "network";
inline constexpr const char* weights = "weights";
inline constexpr const char* basis = "basis";
inline constexpr const char* basis_values = "basis-values";
inline constexpr const char* provenance = "provenance";
inline constexpr const char* licence = "licence";
inline constexpr const char* certificate = "certificate";
inline constexpr const char* proof = "proof";
}  // namespace section

// The contexts of section "weights": which layer of its region, and for wide ones which digit.
inline constexpr std::uint32_t weight_contexts = 9;
constexpr std::uint32_t weight_context(std::size_t layer, std::size_t layers) {
  return layer + 1 == layers ? 2 : layer == 0 ? 0 : 1;
}

// Signed steps as small unsigned numbers: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...; all modulo 2^32.
constexpr std::uint32_t to_zigzag(std::uint32_t step) {
  return step << 1 ^ (0u - (step >> 31));
}
constexpr std::uint32_t from_zigzag(std::uint32_t zigzag) {
  return zigzag >> 1 ^ (0u - (zigzag & 1));
}

// What corner `at`, number k of its polygon, is stored as a step from: the corner at the same place in the polygon
// before, of `previous_size` corners, or else the corner before it.
inline std::uint32_t corner_before(const std::vector<std::uint32_t>& corners, std::size_t at, std::uint32_t k,
                                   std::uint32_t previous_size) {
  if (k < previous_size) return corners[at - previous_size];
  return at > 0 ? corners[at - 1] : 0;
}

}  // namespace fb::archive
