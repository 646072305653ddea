#include "bake/rig/gltf/gltf_materials.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "bake/rig/gltf/gltf_image.h"
#include "bake/rig/gltf/gltf_mesh.h"
#include "bake/rig/gltf/texture_placement.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Nothing of a mode that there is not.
std::optional<Wrap> wrap_from(int mode) {
  if (mode == TINYGLTF_TEXTURE_WRAP_REPEAT) return Wrap::repeat;
  if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp;
  if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return Wrap::mirror;
  return std::nullopt;
}

std::optional<AlphaMode> alpha_mode_from(const std::string& name) {
  if (name.empty() || name == "OPAQUE") return AlphaMode::opaque;
  if (name == "MASK") return AlphaMode::mask;
  if (name == "BLEND") return AlphaMode::blend;
  return std::nullopt;
}

// Whether a KHR_texture_transform changes anything.
bool transforms(const tinygltf::Value& transform) {
  const auto is = [&](const char* key, double value) {
    if (!transform.IsObject() || !transform.Has(key)) return true;
    const tinygltf::Value& found = transform.Get(key);
    for (int i = 0; i < static_cast<int>(found.ArrayLen()); ++i)
      if (!found.Get(i).IsNumber() || found.Get(i).GetNumberAsDouble() != value) return false;
    return found.IsArray() || (found.IsNumber() && found.GetNumberAsDouble() == value);
  };
  return !is("offset", 0) || !is("rotation", 0) || !is("scale", 1);
}

// Reads one material after another, and notes the images that they use.
class MaterialReader {
 public:
  MaterialReader(const tinygltf::Model& model, LeftOut& left_out) : model_(model), left_out_(left_out) {}

  Material read(const tinygltf::Material& from) {
    Material to;
    name_ = shown_name(from.name);
    placed_ = common_placement(from).has_value();
    to.name = from.name;
    const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
    std::ranges::transform(pbr.baseColorFactor, to.base_colour.begin(), [](double x) { return static_cast<float>(x); });
    std::ranges::transform(from.emissiveFactor, to.emissive.begin(), [](double x) { return static_cast<float>(x); });
    to.metallic = static_cast<float>(pbr.metallicFactor);
    to.roughness = static_cast<float>(pbr.roughnessFactor);
    const auto alpha_mode = alpha_mode_from(from.alphaMode);
    if (!alpha_mode) left_out_.add("unknown alpha modes are OPAQUE, of materials", name_);
    to.alpha_mode = alpha_mode.value_or(AlphaMode::opaque);
    to.alpha_cutoff = static_cast<float>(from.alphaCutoff);
    to.double_sided = from.doubleSided;
    if (const auto strength = from.extensions.find("KHR_materials_emissive_strength");
        strength != from.extensions.end() && strength->second.IsObject() && strength->second.Has("emissiveStrength"))
      for (float& factor : to.emissive)
        factor *= static_cast<float>(strength->second.Get("emissiveStrength").GetNumberAsDouble());
    note_extensions(from.extensions);
    note_extensions(pbr.extensions);
    add_texture(TextureSlot::base_colour, pbr.baseColorTexture, 1, to);
    add_texture(TextureSlot::metallic_roughness, pbr.metallicRoughnessTexture, 1, to);
    add_texture(TextureSlot::normal, from.normalTexture, from.normalTexture.scale, to);
    add_texture(TextureSlot::occlusion, from.occlusionTexture, from.occlusionTexture.strength, to);
    add_texture(TextureSlot::emissive, from.emissiveTexture, 1, to);
    return to;
  }

 private:
  void note_extensions(const tinygltf::ExtensionMap& extensions) {
    for (const auto& [extension, value] : extensions)
      if (extension != "KHR_materials_emissive_strength")
        left_out_.add("the extension " + extension + " of materials is left out", name_);
  }

  // The texture coordinates that a texture uses.
  template <class TextureInfo>
  int coordinates_of(const TextureInfo& info) {
    int coordinates = info.texCoord;
    for (const auto& [extension, value] : info.extensions) {
      if (extension != "KHR_texture_transform") {
        left_out_.add("the extension " + extension + " of textures is left out", name_);
        continue;
      }
      if (transforms(value) && !placed_) left_out_.add("KHR_texture_transform is left out, of materials", name_);
      if (value.IsObject() && value.Get("texCoord").IsInt()) coordinates = value.Get("texCoord").GetNumberAsInt();
    }
    return coordinates;
  }

  // The image of a texture: a compressed one rather than what is there for programs that cannot read that; -1: none.
  static int image_of(const tinygltf::Texture& texture) {
    for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp"}) {
      const auto found = texture.extensions.find(name);
      if (found == texture.extensions.end() || !found->second.IsObject()) continue;
      if (const tinygltf::Value& source = found->second.Get("source"); source.IsInt()) return source.Get<int>();
    }
    return texture.source;
  }

  template <class TextureInfo>
  void add_texture(TextureSlot slot, const TextureInfo& info, double scale, Material& to) {
    if (info.index < 0) return;
    if (static_cast<std::size_t>(info.index) >= model_.textures.size())
      return left_out_.add("textures that there are not are left out, of materials", name_);
    const tinygltf::Texture& texture = model_.textures[static_cast<std::size_t>(info.index)];
    if (coordinates_of(info) != 0)
      return left_out_.add("textures that use other texture coordinates than the first are left out, of materials",
                           name_);
    const int image = image_of(texture);
    if (image < 0) return left_out_.add("textures without an image are left out, of materials", name_);
    Texture read{slot, static_cast<std::uint32_t>(image), Wrap::repeat, Wrap::repeat, static_cast<float>(scale)};
    if (texture.sampler >= 0) {
      const bool known = static_cast<std::size_t>(texture.sampler) < model_.samplers.size();
      const tinygltf::Sampler sampler =
          known ? model_.samplers[static_cast<std::size_t>(texture.sampler)] : tinygltf::Sampler();
      const auto wrap_u = wrap_from(sampler.wrapS), wrap_v = wrap_from(sampler.wrapT);
      if (!known || !wrap_u || !wrap_v)
        left_out_.add("unknown ways to wrap textures are to repeat them, of materials", name_);
      read.wrap_u = wrap_u.value_or(Wrap::repeat);
      read.wrap_v = wrap_v.value_or(Wrap::repeat);
    }
    to.textures.push_back(read);
  }

  const tinygltf::Model& model_;
  LeftOut& left_out_;
  std::string name_;     // of the material that is read, for notes
  bool placed_ = false;  // texture coordinates are changed as its textures want them
};

// Sets the materials of parts, which are those of the file, to their places among those that are used. Returns the
// indices in the file.
std::set<std::uint32_t> use_materials(std::vector<MeshPart>& parts, std::size_t count, LeftOut& left_out) {
  std::set<std::uint32_t> used;
  for (MeshPart& part : parts)
    for (MaterialRun& run : part.materials) {
      if (run.material == no_material) continue;
      if (run.material >= count) {
        left_out.add("materials that there are not are left out, of meshes", part.name);
        run.material = no_material;
        continue;
      }
      used.insert(run.material);
    }
  std::map<std::uint32_t, std::uint32_t> places;
  for (const std::uint32_t material : used) places.emplace(material, static_cast<std::uint32_t>(places.size()));
  for (MeshPart& part : parts)
    for (MaterialRun& run : part.materials)
      if (run.material != no_material) run.material = places.at(run.material);
  return used;
}

// Reads the images of the materials' textures and sets these to them. Textures whose image is of no known kind are left
// out.
std::vector<Image> use_images(const GltfFile& file, std::vector<Material>& materials, LeftOut& left_out) {
  std::set<std::uint32_t> used;
  for (const Material& material : materials)
    for (const Texture& texture : material.textures) used.insert(texture.image);
  std::vector<Image> images;
  std::map<std::uint32_t, std::uint32_t> places;
  for (const std::uint32_t index : used) {
    Image image;
    try {
      image = read_gltf_image(file, index);
    } catch (const Error& error) {
      left_out.add_broken(error.what());
      continue;
    }
    if (image.media_type.empty()) {
      left_out.add("images that are no PNG, JPEG, KTX2 or WebP are left out", shown_name(image.name));
      continue;
    }
    places.emplace(index, static_cast<std::uint32_t>(images.size()));
    images.push_back(std::move(image));
  }
  for (Material& material : materials) {
    std::erase_if(material.textures, [&](const Texture& texture) { return !places.contains(texture.image); });
    for (Texture& texture : material.textures) texture.image = places.at(texture.image);
  }
  return images;
}

}  // namespace

Character read_gltf_materials(const GltfFile& file, std::vector<MeshPart>& parts, LeftOut& left_out) {
  const std::vector<tinygltf::Material>& materials = file.model().materials;
  MaterialReader reader(file.model(), left_out);
  Character character;
  for (const std::uint32_t index : use_materials(parts, materials.size(), left_out))
    with_context(format("material %u (\"%s\")", index, materials[index].name.c_str()),
                 [&] { character.materials.push_back(reader.read(materials[index])); });
  character.images = use_images(file, character.materials, left_out);
  return character;
}

}  // namespace fb::bake
