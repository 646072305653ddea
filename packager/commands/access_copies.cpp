#include "commands/access_copies.h"

#include <facebaker/facebaker_bake.hpp>
#include <filesystem>

#include "base/file.h"
#include "base/progress.h"
#include "commands/export_blendshapes.h"
#include "commands/moving_region.h"
#include "commands/pose_evaluator.h"
#include "export/character_appearance.h"
#include "render/png_file.h"
#include "render/pose_renderer.h"

namespace fb::tool {
namespace {

constexpr Resolution picture_pixels = {640, 800};

void draw_face(PoseEvaluator& evaluator, const std::string& picture) {
  const CharacterView& character = evaluator.character();
  View view;
  view.region = moving_region(evaluator);
  const PoseRenderer renderer(character.mesh, {}, character.up_axis, view, picture_pixels, evaluator.parallel(),
                              appearance_of(character));
  write_png(picture, renderer.draw(character.mesh.points));
}

Poses rest_pose(const facebaker::Model& model) {
  Poses poses;
  poses.controls = model.rest_controls();
  poses.frames = 1;
  return poses;
}

}  // namespace

void write_access_copies(const std::string& archive, const std::string& base, const Parallel& parallel) {
  const facebaker::Archive opened(archive);
  const fb_archive_info info = opened.info();
  const facebaker::Model model(info.bytes, info.byte_count);
  PoseEvaluator evaluator(model, parallel);
  draw_face(evaluator, base + ".png");
  BlendshapeExport options;
  options.licence = info.licence;
  const ExportResult exported =
      export_blendshapes(evaluator, rest_pose(model), options, base + ".glb", silent_progress());
  const std::string name = std::filesystem::path(base).filename().string();
  std::string text = "Access copies of data/archives/" + name + ", for looking at; the archive is what counts.\n\n" +
                     name + ".png: the face at rest\n" + name + ".glb: glTF 2.0 with blendshapes, an approximation\n";
  for (const std::string& line : exported.lines) text += "  " + line + "\n";
  for (const std::string& note : exported.notes) text += "  " + note + "\n";
  write_file(base + ".txt", text);
}

}  // namespace fb::tool
