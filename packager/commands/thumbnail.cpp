#include "commands/thumbnail.h"

#include <algorithm>

#include "commands/library_callback.h"
#include "commands/moving_region.h"
#include "commands/pose_evaluator.h"
#include "export/character_appearance.h"
#include "render/palette_png.h"
#include "render/pose_renderer.h"

namespace fb::tool {
namespace {

// File managers show it at 128 to 256. 2 to 7 KB of clay, up to 20 KB with textures, and never more than 38 KB.
constexpr int thumbnail_pixels = 192;

fb_status draw(void* user, const void* archive, std::uint64_t archive_bytes, void* png, std::uint64_t* png_bytes,
               char* message, std::uint32_t message_size) {
  return answer_library(message, message_size, [&] {
    const facebaker::Model model(archive, archive_bytes);
    const std::vector<std::byte> picture = draw_thumbnail(model, *static_cast<const Parallel*>(user));
    *png_bytes = picture.size();
    std::copy_n(picture.data(), std::min<std::size_t>(picture.size(), FB_THUMBNAIL_BYTES),
                static_cast<std::byte*>(png));
  });
}

}  // namespace

std::vector<std::byte> draw_thumbnail(const facebaker::Model& model, const Parallel& parallel) {
  PoseEvaluator evaluator(model, parallel);
  const CharacterView& character = evaluator.character();
  View view;
  view.region = moving_region(evaluator);
  const PoseRenderer renderer(character.mesh, {}, character.up_axis, view, {thumbnail_pixels, thumbnail_pixels},
                              parallel, appearance_of(character));
  return palette_png(renderer.draw(character.mesh.points));
}

void draw_thumbnail_of(fb_bake_desc& bake, Parallel& parallel) {
  bake.draw_thumbnail = draw;
  bake.thumbnail_user = &parallel;
}

}  // namespace fb::tool
