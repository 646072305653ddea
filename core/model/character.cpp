#include "model/character.h"

#include <cmath>

#include "base/status.h"

namespace fb {
namespace {

void check_material(const Material& material, std::size_t index, std::size_t images) {
  const std::string name = format("material %zu (\"%s\")", index, material.name.c_str());
  bool finite =
      std::isfinite(material.metallic) && std::isfinite(material.roughness) && std::isfinite(material.alpha_cutoff);
  for (const float factor : material.base_colour) finite = finite && std::isfinite(factor);
  for (const float factor : material.emissive) finite = finite && std::isfinite(factor);
  unsigned slots = 0;
  for (const Texture& texture : material.textures) {
    finite = finite && std::isfinite(texture.scale);
    const unsigned slot = 1u << static_cast<unsigned>(texture.slot);
    if (slots & slot) fail(Status::bad_data, "%s has two textures in one slot", name.c_str());
    slots |= slot;
    if (texture.image >= images)
      fail(Status::bad_data, "%s has a texture of image %u of %zu", name.c_str(), texture.image, images);
  }
  if (!finite) fail(Status::not_finite, "%s has a factor that is not finite", name.c_str());
}

}  // namespace

void check(const Character& character, const Mesh& rest) {
  const std::size_t materials = character.materials.size();
  for (std::size_t m = 0; m < materials; ++m) check_material(character.materials[m], m, character.images.size());
  for (const MeshPart& part : rest.parts)
    for (const MaterialRun& run : part.materials)
      if (run.material != no_material && run.material >= materials)
        fail(Status::bad_data, "mesh \"%s\" names material %u of %zu", part.name.c_str(), run.material, materials);
}

}  // namespace fb
