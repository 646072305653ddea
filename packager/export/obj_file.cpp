#include "export/obj_file.h"

#include "base/file.h"
#include "export/number_text.h"

namespace fb::tool {
namespace {

// A line with a name, in which blanks become underscores.
void append_name(std::string& text, const char* keyword, const std::string& name) {
  text += keyword;
  for (const char c : name) text += static_cast<unsigned char>(c) > ' ' ? c : '_';
}

void append_material(std::string& text, const CharacterView& character, std::uint32_t material) {
  if (material == FB_NO_MATERIAL) return append_name(text, "\nusemtl ", "none");
  const std::string name = character.materials[material].name;
  append_name(text, "\nusemtl ", name.empty() ? "material" + std::to_string(material) : name);
}

// Appends the polygons of one mesh after another; keeps where it is.
class PolygonText {
 public:
  explicit PolygonText(const MeshView& mesh) : mesh_(mesh) {}

  void append_polygons(std::string& text, std::uint32_t count) {
    for (const std::size_t end = polygon_ + count; polygon_ < end; ++polygon_) {
      text += "\nf";
      for (std::uint32_t k = 0; k < mesh_.polygon_sizes[polygon_]; ++k, ++corner_) {
        text += ' ';
        append_number(text, std::uint64_t{mesh_.polygon_corners[corner_]} + 1);
        if (mesh_.uvs.empty()) continue;
        text += '/';
        append_number(text, std::uint64_t{mesh_.uv_corners[corner_]} + 1);
      }
    }
  }

 private:
  const MeshView& mesh_;
  std::size_t polygon_ = 0, corner_ = 0;
};

}  // namespace

void write_obj(const std::filesystem::path& path, const CharacterView& character, std::span<const float> points) {
  const MeshView& mesh = character.mesh;
  std::string text;
  append_name(text, "o ", character.mesh_name(0));
  for (std::size_t i = 0; i < points.size(); ++i) {
    text += i % 3 == 0 ? "\nv " : " ";
    append_number(text, points[i]);
  }
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i) {
    text += i % 2 == 0 ? "\nvt " : " ";
    append_number(text, mesh.uvs[i]);
  }
  PolygonText polygons(mesh);
  for (std::size_t m = 0; m < character.meshes.size(); ++m) {
    if (m > 0) append_name(text, "\no ", character.mesh_name(m));
    for (const fb_material_run& run : std::span(character.meshes[m].runs, character.meshes[m].run_count)) {
      if (!character.materials.empty()) append_material(text, character, run.material);
      polygons.append_polygons(text, run.polygon_count);
    }
  }
  text += '\n';
  write_file(path, text);
}

}  // namespace fb::tool
