#include "export/usda_materials.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "export/number_text.h"
#include "export/usda_text.h"

namespace fb::tool {
namespace {

std::string usda_input(const char* declaration, float value) {
  std::string text = std::string("                float inputs:") + declaration + " = ";
  append_number(text, value);
  return text + "\n";
}

}  // namespace

UsdaMaterials::UsdaMaterials(const CharacterView& character, const std::string& root, const std::string& scope)
    : character_(character), root_(root), scope_(scope) {
  std::set<std::string> taken;
  for (std::size_t m = 0; m < character.materials.size(); ++m) {
    const std::string name = character.materials[m].name;
    prims_.push_back(usda_identifier(name.empty() ? "material" : name, taken));
  }
}

bool UsdaMaterials::binds(std::size_t mesh) const {
  const std::span runs(character_.meshes[mesh].runs, character_.meshes[mesh].run_count);
  return std::ranges::any_of(runs, [](const fb_material_run& run) { return run.material != FB_NO_MATERIAL; });
}

std::string UsdaMaterials::binding(std::size_t mesh) const {
  const std::span runs(character_.meshes[mesh].runs, character_.meshes[mesh].run_count);
  if (!binds(mesh)) return "";
  const auto target = [&](const fb_material_run& run) {
    return "rel material:binding = <" + root_ + "/" + scope_ + "/" + prims_[run.material] + ">\n";
  };
  if (runs.size() == 1) return "        " + target(runs[0]);
  std::string text = "        uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"\n";
  std::set<std::string> taken;
  std::uint32_t first = 0;
  for (const fb_material_run& run : runs) {
    std::vector<std::uint32_t> polygons(run.polygon_count);
    std::iota(polygons.begin(), polygons.end(), first);
    first += run.polygon_count;
    if (run.material == FB_NO_MATERIAL) continue;
    text += "\n        def GeomSubset " + usda_string(usda_identifier(prims_[run.material], taken)) +
            " (\n            prepend apiSchemas = [\"MaterialBindingAPI\"]\n        )\n        {\n"
            "            uniform token elementType = \"face\"\n"
            "            uniform token familyName = \"materialBind\"\n"
            "            int[] indices = " +
            usda_integers(polygons) + "\n            " + target(run) + "        }\n";
  }
  return text;
}

std::string UsdaMaterials::scope() const {
  if (prims_.empty()) return "";
  std::string text = "\n    def Scope " + usda_string(scope_) + "\n    {\n";
  for (std::size_t m = 0; m < prims_.size(); ++m) {
    const fb_material& material = character_.materials[m];
    const std::string path = root_ + "/" + scope_ + "/" + prims_[m] + "/Surface.outputs:surface";
    text += "        def Material " + usda_string(prims_[m]) +
            "\n        {\n            token outputs:surface.connect = <" + path +
            ">\n\n            def Shader \"Surface\"\n            {\n" +
            "                uniform token info:id = \"UsdPreviewSurface\"\n" +
            "                color3f inputs:diffuseColor = " + usda_tuple({material.base_colour, 3}) + "\n" +
            "                color3f inputs:emissiveColor = " + usda_tuple({material.emissive, 3}) + "\n" +
            usda_input("metallic", material.metallic) + usda_input("roughness", material.roughness);
    if (material.alpha_mode != FB_ALPHA_OPAQUE) text += usda_input("opacity", material.base_colour[3]);
    if (material.alpha_mode == FB_ALPHA_MASK) text += usda_input("opacityThreshold", material.alpha_cutoff);
    text += "                token outputs:surface\n            }\n        }\n";
  }
  return text + "    }\n";
}

}  // namespace fb::tool
