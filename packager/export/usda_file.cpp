#include "export/usda_file.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/file.h"
#include "base/length_units.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "export/number_text.h"
#include "export/usda_materials.h"
#include "export/usda_text.h"

namespace fb::tool {
namespace {

// Collects text and writes it piece by piece: a file may be far larger than its scene.
class UsdaFile {
 public:
  explicit UsdaFile(const std::filesystem::path& path) : file_(path) {}

  void add(const std::string& text) {
    text_ += text;
    constexpr std::size_t piece = 1u << 20;
    if (text_.size() > piece) flush();
  }
  // A line, `level` blocks deep.
  void line(std::size_t level, const std::string& text) { add(std::string(4 * level, ' ') + text + "\n"); }
  void commit() {
    flush();
    file_.commit();
  }

 private:
  void flush() {
    file_.write(std::as_bytes(std::span(text_)));
    text_.clear();
  }

  AtomicFile file_;
  std::string text_;
};

std::string decimal(double number) {
  std::string text;
  append_number(text, number);
  return text;
}

void add_layer_head(UsdaFile& file, const UsdScene& scene, const std::string& prim) {
  file.line(0, "#usda 1.0");
  file.line(0, "(");
  file.line(1, "customLayerData = {");
  file.line(2, "string generator = " + usda_string("FaceBaker " FB_VERSION));
  if (!scene.licence.empty()) file.line(2, "string licence = " + usda_string(scene.licence));
  if (!scene.about.empty()) file.line(2, "string about = " + usda_string(scene.about));
  file.line(1, "}");
  file.line(1, "defaultPrim = " + usda_string(prim));
  file.line(1, "metersPerUnit = " + decimal(metres_per(scene.character.units).value_or(1)));
  file.line(1, scene.character.up_axis == "z" ? "upAxis = \"Z\"" : "upAxis = \"Y\"");
  if (scene.frames > 1) {
    file.line(1, "startTimeCode = 0");
    file.line(1, "endTimeCode = " + std::to_string(scene.frames - 1));
    file.line(1, "timeCodesPerSecond = " + decimal(scene.fps));
    file.line(1, "framesPerSecond = " + decimal(scene.fps));
  }
  file.line(0, ")");
  file.line(0, "");
}

// The texture coordinates that a mesh uses, counted from its first.
void add_uvs(UsdaFile& file, const MeshView& mesh) {
  if (mesh.uvs.empty()) return;
  std::vector<std::uint32_t> used(mesh.uv_corners.begin(), mesh.uv_corners.end());
  std::ranges::sort(used);
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<float> uvs;
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t uv : used)
    uvs.insert(uvs.end(), {mesh.uvs[2 * std::size_t(uv)], mesh.uvs[2 * std::size_t(uv) + 1]});
  for (const std::uint32_t uv : mesh.uv_corners)
    corners.push_back(static_cast<std::uint32_t>(std::ranges::lower_bound(used, uv) - used.begin()));
  file.line(2, "texCoord2f[] primvars:st = " + usda_tuples(uvs, 2) + " (");
  file.line(3, "interpolation = \"faceVarying\"");
  file.line(2, ")");
  file.line(2, "int[] primvars:st:indices = " + usda_integers(corners));
}

// The box of points: its least and its greatest corner.
std::string extent_of(std::span<const float> points) {
  std::array<float, 6> box = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
  for (std::size_t i = 0; i < points.size(); ++i) {
    box[i % 3] = std::min(box[i % 3], points[i]);
    box[3 + i % 3] = std::max(box[3 + i % 3], points[i]);
  }
  return usda_tuples(box, 3);
}

// The points of a mesh: the first frame as the default, after the samples of all, which readers that look for the last
// of both need.
void add_points(UsdaFile& file, const UsdScene& scene, std::size_t mesh,
                const std::function<void(std::size_t)>& progress) {
  std::vector<float> first;
  std::vector<std::string> extents;
  if (scene.frames > 1) file.line(2, "point3f[] points.timeSamples = {");
  for_frame_blocks(scene.positions, scene.frames,
                   [&](std::size_t begin, std::size_t count, std::span<const float> block) {
                     const std::size_t size = block.size() / count;
                     for (std::size_t f = 0; f < count; ++f) {
                       const std::span<const float> points = scene.character.part(mesh, block.subspan(f * size, size));
                       if (first.empty()) first.assign(points.begin(), points.end());
                       if (scene.frames > 1)
                         file.line(3, std::to_string(begin + f) + ": " + usda_tuples(points, 3) + ",");
                       extents.push_back(extent_of(points));
                       progress(mesh * scene.frames + begin + f + 1);
                     }
                   });
  if (scene.frames > 1) {
    file.line(2, "}");
    file.line(2, "float3[] extent.timeSamples = {");
    for (std::size_t f = 0; f < scene.frames; ++f) file.line(3, std::to_string(f) + ": " + extents[f] + ",");
    file.line(2, "}");
  }
  file.line(2, "float3[] extent = " + extents[0]);
  file.line(2, "point3f[] points = " + usda_tuples(first, 3));
}

void add_mesh_prim(UsdaFile& file, const UsdScene& scene, std::size_t index, const std::string& prim,
                   const UsdaMaterials& materials, const std::function<void(std::size_t)>& progress) {
  const SingleMesh single(scene.character, index);
  const MeshView& mesh = single.view();
  file.line(1, "def Mesh " + usda_string(prim) + " (");
  file.line(2, "displayName = " + usda_string(scene.character.mesh_name(index)));
  if (materials.binds(index)) file.line(2, "prepend apiSchemas = [\"MaterialBindingAPI\"]");
  file.line(1, ")");
  file.line(1, "{");
  file.line(2, "int[] faceVertexCounts = " + usda_integers(mesh.polygon_sizes));
  file.line(2, "int[] faceVertexIndices = " + usda_integers(mesh.polygon_corners));
  add_uvs(file, mesh);
  file.line(2, "uniform token subdivisionScheme = \"none\"");
  add_points(file, scene, index, progress);
  file.add(materials.binding(index));
  file.line(1, "}");
}

}  // namespace

std::vector<std::string> write_usda(const std::filesystem::path& path, const UsdScene& scene,
                                    const std::function<void(std::size_t)>& progress) {
  const CharacterView& character = scene.character;
  UsdaFile file(path);
  std::set<std::string> roots, names;
  const std::string root = usda_identifier(character.name, roots);
  add_layer_head(file, scene, root);
  file.line(0, "def Xform " + usda_string(root) + " (");
  file.line(1, "displayName = " + usda_string(character.name));
  file.line(1, "kind = \"component\"");
  file.line(0, ")");
  file.line(0, "{");
  std::vector<std::string> prims;
  for (std::size_t m = 0; m < character.meshes.size(); ++m)
    prims.push_back(usda_identifier(character.mesh_name(m), names));
  const UsdaMaterials materials(character, "/" + root, usda_identifier("Materials", names));
  for (std::size_t m = 0; m < prims.size(); ++m) add_mesh_prim(file, scene, m, prims[m], materials, progress);
  file.add(materials.scope());
  file.line(0, "}");
  file.commit();
  std::vector<std::string> notes;
  if (!character.images.empty())
    notes.push_back(format("%zu images and the textures that use them are left out: text cannot hold them",
                           character.images.size()));
  if (!character.sockets.empty()) notes.push_back(format("%zu sockets are left out", character.sockets.size()));
  if (!character.joints.empty()) notes.push_back(format("%zu joints are left out", character.joints.size()));
  return notes;
}

}  // namespace fb::tool
