// Constants of the .fbk container that its reader and writer share, and the names of the sections. See FORMAT.md.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fb::archive {

inline constexpr unsigned char archive_signature[8] = {0x89, 'F', 'B', 'K', 0x0d, 0x0a, 0x1a, 0x0a};
inline constexpr std::uint16_t archive_major = 2, archive_minor = 1;  // the newest that there is

inline constexpr std::size_t header_bytes = 24, table_row_bytes = 72, checksum_bytes = 8, section_name_bytes = 32;
inline constexpr std::uint32_t max_sections = 64;
inline constexpr std::uint32_t max_string_bytes = 0xffff;

inline constexpr std::uint32_t section_required = 1;  // the only section flag
enum class Codec : std::uint32_t { none = 0, deflate = 1 };

namespace section {
inline constexpr const char* definition = "definition";
inline constexpr const char* polygons = "polygons";
inline constexpr const char* geometry = "geometry";
inline constexpr const char* labels = "labels";
inline constexpr const char* uvs = "uvs";
inline constexpr const char* meshes = "meshes";
inline constexpr const char* materials = "materials";
inline constexpr const char* images = "images";
inline constexpr const char* sockets = "sockets";
inline constexpr const char* about = "about";
inline constexpr const char* thumbnail = "thumbnail";
inline constexpr const char* channels = "channels";
inline constexpr const char* expected_errors = "expected-errors";
inline constexpr const char* exact_poses = "exact-poses";
inline constexpr const char* joints = "joints";
inline constexpr const char* skin = "skin";
inline constexpr const char* driven_joints = "driven-joints";
inline constexpr const char* levels = "levels";
inline constexpr const char* network = "network";
inline constexpr const char* weights = "weights";
inline constexpr const char* basis = "basis";
inline constexpr const char* basis_values = "basis-values";
inline constexpr const char* provenance = "provenance";
inline constexpr const char* licence = "licence";
inline constexpr const char* certificate = "certificate";
inline constexpr const char* proof = "proof";
}  // namespace section

// Zigzag coding maps signed differences to small unsigned numbers: 0, -1, 1, -2, ... to 0, 1, 2, 3, ...; modulo 2^32.
constexpr std::uint32_t to_zigzag(std::uint32_t difference) {
  return difference << 1 ^ (0u - (difference >> 31));
}
constexpr std::uint32_t from_zigzag(std::uint32_t zigzag) {
  return zigzag >> 1 ^ (0u - (zigzag & 1));
}

}  // namespace fb::archive
