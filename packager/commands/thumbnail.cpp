#include "commands/thumbnail.h"

#include <facebaker/facebaker_bake.hpp>

#include "export/character_view.h"
#include "render/palette_png.h"
#include "render/pose_renderer.h"

namespace fb::tool {
namespace {

constexpr int thumbnail_pixels = 192;  // about 6 KB; file managers show it at 128 to 256

std::vector<std::byte> draw_rest(const MeshView& mesh, const char* up_axis, const Parallel& parallel) {
  const Resolution size = {thumbnail_pixels, thumbnail_pixels};
  const PoseRenderer renderer(mesh, {}, up_axis, View{}, size, parallel);
  return palette_png(renderer.draw(mesh.points));
}

}  // namespace

std::vector<std::byte> draw_thumbnail(const facebaker::Source& source, const Parallel& parallel) {
  const fb_source_info info = facebaker::SourceView(source).info();
  return draw_rest({{info.rest_positions, std::size_t{3} * info.vertex_count},
                    {info.polygon_sizes, info.polygon_count},
                    {info.polygon_corners, info.polygon_corner_count}},
                   info.up_axis, parallel);
}

std::vector<std::byte> draw_thumbnail(const facebaker::Model& model, const Parallel& parallel) {
  return draw_rest(mesh_of(model), fb_up_axis(model.get()), parallel);
}

}  // namespace fb::tool
