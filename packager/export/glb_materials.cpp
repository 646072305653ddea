#include "export/glb_materials.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <tuple>

#include "base/shown_path.h"
#include "base/status.h"
#include "export/valid_utf8.h"

namespace fb::tool {
namespace {

// A type of image that glTF holds, and the extension that it takes; null: none.
struct ImageType {
  std::string_view media_type;
  const char* extension;
};
constexpr ImageType image_types[] = {{"image/png", nullptr},
                                     {"image/jpeg", nullptr},
                                     {"image/ktx2", "KHR_texture_basisu"},
                                     {"image/webp", "EXT_texture_webp"}};

const ImageType* type_of(const fb_image& image) {
  const auto* found = std::find_if(std::begin(image_types), std::end(image_types),
                                   [&](const ImageType& type) { return type.media_type == image.media_type; });
  return found == std::end(image_types) ? nullptr : found;
}

void list(std::vector<std::string>& extensions, const char* name) {
  if (std::find(extensions.begin(), extensions.end(), name) == extensions.end()) extensions.push_back(name);
}

// Textures of a model, each of one image and one way to go on beyond its borders.
class TextureTable {
 public:
  TextureTable(tinygltf::Model& model, GlbBuffer& buffer, const CharacterView& character,
               std::vector<std::string>& notes)
      : model_(model), character_(character) {
    for (std::size_t i = 0; i < character.images.size(); ++i) images_.push_back(add_image(buffer, i, notes));
  }

  // The texture of the model; -1 if its image is left out.
  int find(const fb_texture& texture) {
    if (images_[texture.image] < 0) return -1;
    const auto [found, added] = textures_.try_emplace({texture.image, texture.wrap_u, texture.wrap_v}, 0);
    if (!added) return found->second;
    tinygltf::Texture made;
    made.sampler = sampler(texture.wrap_u, texture.wrap_v);
    const int image = images_[texture.image];
    if (const char* extension = type_of(character_.images[texture.image])->extension) {
      made.extensions[extension] = tinygltf::Value(tinygltf::Value::Object{{"source", tinygltf::Value(image)}});
      list(model_.extensionsRequired, extension);  // there is no other image to fall back to
    } else {
      made.source = image;
    }
    model_.textures.push_back(made);
    return found->second = static_cast<int>(model_.textures.size()) - 1;
  }

 private:
  int add_image(GlbBuffer& buffer, std::size_t index, std::vector<std::string>& notes) {
    const fb_image& from = character_.images[index];
    const ImageType* type = type_of(from);
    if (!type || from.byte_count == 0) {
      notes.push_back(format(
          "image %zu (\"%s\") %s and is left out", index, shown(from.name).c_str(),
          type ? "is empty" : format("is %s, which glTF does not hold,", shown(from.media_type).c_str()).c_str()));
      return -1;
    }
    tinygltf::Image image;
    image.name = valid_utf8(from.name);
    image.mimeType = from.media_type;
    image.bufferView = buffer.view({static_cast<const std::byte*>(from.bytes), from.byte_count});
    if (type->extension) list(model_.extensionsUsed, type->extension);
    model_.images.push_back(image);
    return static_cast<int>(model_.images.size()) - 1;
  }

  int sampler(std::uint32_t wrap_u, std::uint32_t wrap_v) {
    static constexpr int wraps[] = {TINYGLTF_TEXTURE_WRAP_REPEAT, TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE,
                                    TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT};
    const auto [found, added] = samplers_.try_emplace({wrap_u, wrap_v}, static_cast<int>(model_.samplers.size()));
    if (!added) return found->second;
    tinygltf::Sampler sampler;
    sampler.wrapS = wraps[wrap_u];
    sampler.wrapT = wraps[wrap_v];
    model_.samplers.push_back(sampler);
    return found->second;
  }

  tinygltf::Model& model_;
  const CharacterView& character_;
  std::vector<int> images_;  // index in the model of each image; -1: left out
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, int> textures_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> samplers_;
};

double unit(float factor) {
  return std::clamp(double(factor), 0.0, 1.0);
}

void add_textures(tinygltf::Material& material, const fb_material& from, TextureTable& table) {
  for (const fb_texture& texture : std::span(from.textures, from.texture_count)) {
    const int index = table.find(texture);
    switch (texture.slot) {
      case FB_TEXTURE_BASE_COLOUR:
        material.pbrMetallicRoughness.baseColorTexture.index = index;
        break;
      case FB_TEXTURE_METALLIC_ROUGHNESS:
        material.pbrMetallicRoughness.metallicRoughnessTexture.index = index;
        break;
      case FB_TEXTURE_NORMAL:
        material.normalTexture.index = index;
        material.normalTexture.scale = texture.scale;
        break;
      case FB_TEXTURE_OCCLUSION:
        material.occlusionTexture.index = index;
        material.occlusionTexture.strength = unit(texture.scale);
        break;
      case FB_TEXTURE_EMISSIVE:
        material.emissiveTexture.index = index;
        break;
      default:
        break;
    }
  }
}

// Colours beyond 1 are a colour within it times a strength.
void set_emissive(tinygltf::Model& model, tinygltf::Material& material, const fb_material& from) {
  const double strength = std::max(1.0, double(*std::max_element(from.emissive, from.emissive + 3)));
  for (std::size_t i = 0; i < 3; ++i) material.emissiveFactor[i] = std::max(0.0, from.emissive[i] / strength);
  if (strength == 1) return;
  const char* extension = "KHR_materials_emissive_strength";
  material.extensions[extension] =
      tinygltf::Value(tinygltf::Value::Object{{"emissiveStrength", tinygltf::Value(strength)}});
  list(model.extensionsUsed, extension);
}

tinygltf::Material material_from(tinygltf::Model& model, const fb_material& from) {
  tinygltf::Material material;
  material.name = valid_utf8(from.name);
  tinygltf::PbrMetallicRoughness& pbr = material.pbrMetallicRoughness;
  for (std::size_t i = 0; i < 4; ++i) pbr.baseColorFactor[i] = unit(from.base_colour[i]);
  pbr.metallicFactor = unit(from.metallic);
  pbr.roughnessFactor = unit(from.roughness);
  material.emissiveFactor.assign(3, 0);
  set_emissive(model, material, from);
  if (from.alpha_mode == FB_ALPHA_MASK) {
    material.alphaMode = "MASK";
    material.alphaCutoff = std::max(0.0, double(from.alpha_cutoff));
  }
  if (from.alpha_mode == FB_ALPHA_BLEND) material.alphaMode = "BLEND";
  material.doubleSided = from.double_sided != 0;
  return material;
}

tinygltf::Material clay_material() {
  tinygltf::Material material;
  material.name = "clay";
  material.pbrMetallicRoughness.baseColorFactor = {0.5, 0.345, 0.275, 1};
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 0.7;
  material.doubleSided = true;
  return material;
}

}  // namespace

void add_materials(tinygltf::Model& model, GlbBuffer& buffer, const CharacterView& character,
                   std::vector<std::string>& notes) {
  TextureTable table(model, buffer, character, notes);
  bool textured = false;
  for (const fb_material& from : character.materials) {
    model.materials.push_back(material_from(model, from));
    textured = textured || from.texture_count > 0;
    if (!character.mesh.uvs.empty()) add_textures(model.materials.back(), from, table);
  }
  if (textured && character.mesh.uvs.empty())
    notes.push_back("there are no texture coordinates, so textures are left out");
  if (character.materials.empty()) model.materials.push_back(clay_material());
}

int material_of(const CharacterView& character, const fb_material_run& run) {
  if (character.materials.empty()) return 0;
  return run.material == FB_NO_MATERIAL ? -1 : static_cast<int>(run.material);
}

}  // namespace fb::tool
