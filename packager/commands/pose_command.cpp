#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/rig/source.h"
#include "base/file.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/json_text.h"
#include "commands/pose_animation.h"
#include "commands/pose_controls.h"
#include "commands/progress_bar.h"
#include "export/obj_file.h"
#include "render/png_file.h"
#include "render/pose_renderer.h"
#include "report/model_mesh.h"

namespace fb::tool {
using namespace archive;
using namespace bake;
namespace {

struct PoseCommand {
  std::string archive, out, beside, size = "640x800";
  PoseRequest request;
  std::optional<std::size_t> frame;
  double fps = 30;
  float full_scale = 0;
  View view;
  Parallel parallel;
  bool json = false;

  void run();

 private:
  void write_still_files(const PackedModel& model, const Evaluator& evaluator, const Poses& poses);
  void print(const Poses& poses) const;

  std::vector<std::string> files_;  // written
  double worst_ = 0;                // largest distance from the true rig over the diagonal, if there is one beside
};

Resolution resolution_from(const std::string& size) {
  Resolution resolution;
  int read = 0;
  if (std::sscanf(size.c_str(), "%5dx%5d%n", &resolution.width, &resolution.height, &read) != 2 ||
      read != static_cast<int>(size.size()) || std::min(resolution.width, resolution.height) < 16 ||
      std::max(resolution.width, resolution.height) > 8192)
    fail(Status::invalid_argument, "--size %s: give WIDTHxHEIGHT, each from 16 to 8192", size.c_str());
  return resolution;
}

// The clip's frames become NAME.0000.obj, NAME.0001.obj, ...; a single pose keeps the name given.
std::string numbered(const std::filesystem::path& out, std::size_t frame, bool clip) {
  if (!clip) return out.string();
  std::filesystem::path path = out;
  path.replace_extension(format(".%04zu", frame) + out.extension().string());
  return path.string();
}

std::unique_ptr<Source> open_truth(const std::string& name, const PackedModel& model, const std::string& archive) {
  auto source = open_source(name);
  check_same_controls(model.schema, archive.c_str(), source->schema(), name.c_str());
  if (source->rest().vertex_count() != model.rest.vertex_count())
    fail(Status::bad_data, "%s has %zu vertices, %s %zu", archive.c_str(), model.rest.vertex_count(), name.c_str(),
         source->rest().vertex_count());
  return source;
}

void PoseCommand::write_still_files(const PackedModel& model, const Evaluator& evaluator, const Poses& poses) {
  const std::size_t width = evaluator.control_count(), points = 3 * evaluator.vertex_count();
  const bool picture = out.ends_with(".png");
  const auto truth = beside.empty() ? nullptr : open_truth(beside, model, archive);
  std::optional<PoseRenderer> renderer;
  if (picture) renderer.emplace(mesh_view_of(model.rest), model.schema.up_axis, view, resolution_from(size), parallel);
  ProgressBar progress;
  if (poses.frames > 1) progress.begin("writing frames", poses.frames);
  for (std::size_t f = 0; f < poses.frames; ++f) {
    const std::span<const float> controls(&poses.controls[f * width], width);
    const std::vector<float> positions = evaluate_frames(evaluator, controls, parallel);
    const std::string path = numbered(out, f, poses.frames > 1);
    if (!picture) {
      write_obj(path, model.schema.name, mesh_view_of(model.rest), positions);
    } else if (!truth) {
      write_png(path, renderer->draw(positions));
    } else {
      std::vector<float> expected(points);
      truth->evaluate(controls, 1, expected);
      const auto comparison = renderer->draw_comparison({"true rig", expected}, {{"archive", positions}}, full_scale);
      write_png(path, comparison.image);
      worst_ = std::max(worst_, comparison.differences[0].max);
    }
    files_.push_back(path);
    progress.step(f + 1);
  }
}

void PoseCommand::print(const Poses& poses) const {
  if (json) {
    nlohmann::ordered_json figures = {{"files", files_}, {"frames", poses.frames}, {"clamped", poses.clamped}};
    if (!beside.empty()) figures["max"] = worst_;
    std::fputs(json_text(figures).c_str(), stdout);
    return;
  }
  for (const std::string& file : files_) std::printf("%s\n", file.c_str());
  if (!beside.empty()) std::printf("largest distance from the true rig: %.2e of the diagonal\n", worst_);
}

void PoseCommand::run() {
  const bool glb = out.ends_with(".glb"), png = out.ends_with(".png");
  if (!glb && !png && !out.ends_with(".obj"))
    fail(Status::invalid_argument, "--out %s: the name must end in .glb, .obj or .png", out.c_str());
  if (!beside.empty() && !png) fail(Status::invalid_argument, "--beside needs a picture: --out NAME.png");
  if (frame && request.clip.empty()) fail(Status::invalid_argument, "--frame needs --clip");

  const auto bytes = read_file(archive);
  const PackedModel model = with_context(archive, [&] { return read_archive(bytes).model; });
  Poses poses = read_poses(request, model.schema);
  if (frame) {
    if (*frame >= poses.frames)
      fail(Status::invalid_argument, "--frame %zu: %s has frames 0 to %zu", *frame, request.clip.c_str(),
           poses.frames - 1);
    const auto first = poses.controls.begin() + *frame * model.schema.control_count();
    poses.controls = std::vector<float>(first, first + model.schema.control_count());
    poses.frames = 1;
  }
  for (const std::string& note : poses.notes) std::fprintf(stderr, "facebaker pose: %s\n", note.c_str());

  const Evaluator evaluator(model);
  if (!glb) {
    write_still_files(model, evaluator, poses);
  } else {
    GlbScene scene = {model.schema.name,        model.schema.units, model.schema.up_axis,
                      mesh_view_of(model.rest), model.rest.points,  {}};
    std::vector<float> positions;
    if (poses.frames > 1)
      scene.animation = animate(model, evaluator, poses.controls, fps, parallel);
    else
      scene.base = positions = evaluate_frames(evaluator, poses.controls, parallel);
    write_glb(out, scene);
    files_.push_back(out);
  }
  print(poses);
}

}  // namespace

void add_pose(CLI::App& tool) {
  auto command = std::make_shared<PoseCommand>();
  CLI::App* app = tool.add_subcommand("pose", "Pose a face and write it as .glb, .obj or .png");
  add_archive(*app, command->archive);
  app->add_option(
         "--set", command->request.set,
         "A control's value (repeatable); all others are at rest, or as the clip has them. A value outside the "
         "control's range is clamped, and that is said")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  app->add_option("--clip", command->request.clip, "Animation: a NumPy file of frames x controls")
      ->type_name("FILE.npy");
  app->add_option("--frame", command->frame, "Only this frame of the clip, counted from 0")
      ->check(whole_number)
      ->type_name("N");
  app->add_option("--beside", command->beside,
                  "A rig plugin, a .glb or .gltf, or \"sample\": show the true rig, the archive and the error side by "
                  "side (.png)")
      ->type_name("SOURCE");
  app->add_option(
         "--out", command->out,
         "File to write: .glb (mesh, or animation as morph targets), .obj (polygons in the rig's own order) or .png "
         "(shaded picture). The frames of a clip become NAME.0000.obj or .png and so on")
      ->type_name("FILE")
      ->required();
  app->add_option("--fps", command->fps, "Frames a second of the clip, for .glb")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  app->add_option("--yaw", command->view.yaw, "Turn of the camera around the head, degrees, for .png")
      ->capture_default_str();
  app->add_option("--pitch", command->view.pitch, "Rise of the camera, degrees, for .png")
      ->check(CLI::Range(-89.0, 89.0))
      ->capture_default_str();
  app->add_option("--size", command->size, "Size of a picture's panel, for .png")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str();
  app->add_option("--error-scale", command->full_scale,
                  "Error at the end of the error map's scale, over the diagonal; 0: a round number above the largest")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  add_threads(*app, command->parallel);
  add_json_flag(*app, command->json);
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
