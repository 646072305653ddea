#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/joints.h"
#include "model/mesh.h"

namespace fb {

// A picture file as it is, such as a texture.
struct Image {
  std::string name;
  std::string media_type;  // "image/png", "image/jpeg", "image/ktx2", ...
  std::vector<std::byte> bytes;
  bool operator==(const Image&) const = default;
};

// How a texture goes on beyond its borders.
enum class Wrap : std::uint8_t { repeat = 0, clamp = 1, mirror = 2 };

// What a texture is to a material: as in glTF 2.0, which defines how each is shaded.
enum class TextureSlot : std::uint8_t {
  base_colour = 0,
  metallic_roughness = 1,
  normal = 2,
  occlusion = 3,
  emissive = 4
};

struct Texture {
  TextureSlot slot = TextureSlot::base_colour;
  std::uint32_t image = 0;  // index of Character::images
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  float scale = 1;  // of a normal texture; strength of an occlusion texture
  bool operator==(const Texture&) const = default;
};

enum class AlphaMode : std::uint8_t { opaque = 0, mask = 1, blend = 2 };

// The metallic-roughness material of glTF 2.0; its textures use the texture coordinates of the mesh.
struct Material {
  std::string name;                                 // may be empty
  std::array<float, 4> base_colour = {1, 1, 1, 1};  // linear red, green, blue, and alpha
  float metallic = 1, roughness = 1;
  std::array<float, 3> emissive = {0, 0, 0};
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;  // of AlphaMode::mask
  bool double_sided = false;
  std::vector<Texture> textures = {};  // at most one a slot
  bool operator==(const Material&) const = default;
};

// A named frame that follows the surface, for what hangs on it: glasses, hair, an earring.
struct Socket {
  std::string name;                     // unique, not empty
  std::vector<std::uint32_t> vertices;  // at least 3, of one mesh
  std::vector<float> weights;           // of each, above 0
  std::array<float, 12> frame = {};     // at rest: the upper three rows of a 4 x 4 matrix, row after row; its last
                                        // column is the origin
  bool operator==(const Socket&) const = default;
};

inline constexpr std::size_t most_about_bytes = 65536, most_thumbnail_bytes = 65536;
inline constexpr std::uint32_t most_thumbnail_pixels = 512;  // along an edge

// What a character has that no pose changes, besides its mesh: carried from the source into the archive as it is.
struct Character {
  std::vector<Material> materials;
  std::vector<Image> images;
  std::vector<Socket> sockets;
  std::string about;                 // whose it is and what may be done with it: a JSON object; may be empty
  std::vector<std::byte> thumbnail;  // a square PNG; may be empty
  std::vector<Joint> joints = {};    // of the skeleton that carries it; may be none
  Skin skin = {};
  bool operator==(const Character&) const = default;
};

// Gives a socket whose frame is all 0 the axes, at the weighted centre of its vertices. Vertices and weights that there
// are not are left out.
void set_default_frame(Socket& socket, std::span<const float> points);

// Fails unless a thumbnail begins as a PNG of such a size does.
void check_thumbnail(std::span<const std::byte> png);

// Fails, naming material, mesh or socket, on a factor that is not finite, two textures in one slot, an image or a
// material that there is not, a socket of vertices that there are not, of several meshes, or of too few, texts and
// thumbnails that are too long or none, and on joints and skins as check(joints) does; whether a text is JSON is not
// checked. `rest`: the mesh, which has been checked.
void check(const Character& character, const Mesh& rest);

}  // namespace fb
