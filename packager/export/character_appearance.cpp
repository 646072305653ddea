#include "export/character_appearance.h"

#include <algorithm>
#include <map>

#include "base/status.h"
#include "render/shading.h"

namespace fb::tool {
namespace {

constexpr int most_texture_pixels = 1024;  // along an edge: pictures of a face are smaller
constexpr float least_blended = 0.5f;

TextureWrap wrap_of(std::uint32_t wrap) {
  return wrap == FB_WRAP_CLAMP    ? TextureWrap::clamp
         : wrap == FB_WRAP_MIRROR ? TextureWrap::mirror
                                  : TextureWrap::repeat;
}

// The textures of a character, each decoded once.
class DecodedTextures {
 public:
  DecodedTextures(const CharacterView& character, std::vector<Texture>& textures, std::vector<std::string>* notes)
      : character_(character), textures_(textures), notes_(notes) {}

  // Index of the texture of an image; none if it cannot be decoded.
  std::optional<std::size_t> find(std::uint32_t image) {
    const auto [known, added] = of_image_.try_emplace(image);
    if (!added) return known->second;
    const fb_image& file = character_.images[image];
    std::optional<Texture> decoded =
        decode_texture({static_cast<const std::byte*>(file.bytes), file.byte_count}, most_texture_pixels);
    if (!decoded) {
      if (notes_)
        notes_->push_back(format("the texture \"%s\" is not shown: it is no PNG, JPEG or WebP that can be read (%s)",
                                 file.name, file.media_type));
      return std::nullopt;
    }
    textures_.push_back(std::move(*decoded));
    return known->second = textures_.size() - 1;
  }

 private:
  const CharacterView& character_;
  std::vector<Texture>& textures_;
  std::vector<std::string>* notes_;
  std::map<std::uint32_t, std::optional<std::size_t>> of_image_;
};

SurfaceColour colour_of(const fb_material& material, DecodedTextures& textures) {
  SurfaceColour surface = {{material.base_colour[0], material.base_colour[1], material.base_colour[2]}};
  surface.alpha = material.base_colour[3];
  if (material.alpha_mode == FB_ALPHA_MASK) surface.least_alpha = material.alpha_cutoff;
  if (material.alpha_mode == FB_ALPHA_BLEND) surface.least_alpha = least_blended;
  bool glows = true;
  for (std::uint32_t t = 0; t < material.texture_count; ++t) {
    const fb_texture& texture = material.textures[t];
    if (texture.slot == FB_TEXTURE_EMISSIVE) glows = false;  // where, only the texture knows
    if (texture.slot != FB_TEXTURE_BASE_COLOUR) continue;
    surface.texture = textures.find(texture.image);
    surface.wrap_u = wrap_of(texture.wrap_u), surface.wrap_v = wrap_of(texture.wrap_v);
  }
  if (glows) surface.emissive = {material.emissive[0], material.emissive[1], material.emissive[2]};
  return surface;
}

// Whether a material says more than the default one of glTF.
bool tells_colour(const SurfaceColour& surface) {
  const auto differs = [](Vector3 colour, float value) {
    return colour.x != value || colour.y != value || colour.z != value;
  };
  return surface.texture || differs(surface.colour, 1) || differs(surface.emissive, 0) ||
         surface.alpha < surface.least_alpha;
}

// Index of the colour of each triangle: that of its polygon's material, `none` without one.
std::vector<std::uint32_t> colours_of_triangles(const CharacterView& character, std::uint32_t none) {
  std::vector<std::uint32_t> of_triangle;
  for (const fb_mesh& mesh : character.meshes) {
    std::size_t polygon = mesh.first_polygon;
    const auto add = [&](std::size_t count, std::uint32_t colour) {
      for (const std::size_t end = polygon + count; polygon < end; ++polygon)
        of_triangle.insert(of_triangle.end(), character.mesh.polygon_sizes[polygon] - 2, colour);
    };
    for (std::uint32_t r = 0; r < mesh.run_count; ++r)
      add(mesh.runs[r].polygon_count, mesh.runs[r].material == FB_NO_MATERIAL ? none : mesh.runs[r].material);
    add(mesh.first_polygon + mesh.polygon_count - polygon, none);
  }
  return of_triangle;
}

}  // namespace

std::shared_ptr<const Appearance> appearance_of(const CharacterView& character, std::vector<std::string>* notes) {
  auto appearance = std::make_shared<Appearance>();
  DecodedTextures textures(character, appearance->textures, notes);
  for (const fb_material& material : character.materials) appearance->colours.push_back(colour_of(material, textures));
  if (std::ranges::none_of(appearance->colours, tells_colour)) return nullptr;
  appearance->of_triangle = colours_of_triangles(character, static_cast<std::uint32_t>(appearance->colours.size()));
  appearance->colours.push_back({clay});
  const MeshView& mesh = character.mesh;
  if (!mesh.uv_corners.empty())
    for (const std::uint32_t corner : triangle_fans(mesh.polygon_sizes, mesh.uv_corners))
      appearance->uvs.insert(appearance->uvs.end(), {mesh.uvs[2 * corner], mesh.uvs[2 * corner + 1]});
  return appearance;
}

}  // namespace fb::tool
