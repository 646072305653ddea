#include <algorithm>
#include <array>
#include <facebaker/facebaker_bake.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/file_extension.h"
#include "base/output_lock.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/face_rights.h"
#include "commands/moving_region.h"
#include "commands/open_beside.h"
#include "commands/pose_controls.h"
#include "commands/pose_evaluator.h"
#include "commands/pose_expectation.h"
#include "commands/pose_scene.h"
#include "commands/progress_bar.h"
#include "commands/results.h"
#include "commands/rig_options.h"
#include "commands/terminal.h"
#include "export/character_appearance.h"
#include "export/obj_file.h"
#include "render/png_file.h"
#include "render/pose_renderer.h"

namespace fb::tool {
namespace {

struct PoseCommand {
  std::string archive, out, beside, size = "640x800";
  PoseRequest request;
  std::optional<std::size_t> frame;
  SceneOptions scene;
  float error_scale = 0, lod = 0;
  View view;
  Parallel parallel;
  RigOptions rigs;
  bool json = false, whole = false;

  void run();

 private:
  void check_options() const;
  Poses read_frames(const facebaker::Model& model) const;
  void write_stills(PoseEvaluator& evaluator, const Poses& poses);
  void write_still(const std::string& path, const CharacterView& character, const PoseRenderer* renderer,
                   const std::vector<float>& positions, const std::vector<float>& reference);
  void print(const Poses& poses) const;

  std::vector<std::string> files_;  // written
  std::optional<PoseExpectation> expected_;
  std::optional<FaceRights> rights_;
  std::optional<SceneSummary> summary_;
  double worst_ = 0;  // largest distance from the true rig over the diagonal, with --beside
};

Resolution resolution_from(const std::string& size) {
  Resolution resolution;
  int read = 0;
  if (std::sscanf(size.c_str(), "%5dx%5d%n", &resolution.width, &resolution.height, &read) != 2 ||
      read != static_cast<int>(size.size()) || std::min(resolution.width, resolution.height) < 16 ||
      std::max(resolution.width, resolution.height) > 8192)
    fail(Status::invalid_argument, "--size %s: give WIDTHxHEIGHT, each from 16 to 8192", shown(size).c_str());
  return resolution;
}

// The frames of an animation become NAME.0000.obj, NAME.0001.obj, ...; a single pose keeps the name given.
std::string numbered(const std::filesystem::path& out, std::size_t frame, bool clip) {
  if (!clip) return out.string();
  std::filesystem::path path = out;
  path.replace_extension(format(".%04zu", frame) + out.extension().string());
  return path.string();
}

// The corners of the box of each vertex over all poses: a camera that shows them shows every pose.
std::array<std::vector<float>, 8> bounds_of(PoseEvaluator& evaluator, const Poses& poses) {
  const std::size_t width = evaluator.model().control_count();
  std::vector<float> low, high;
  for (std::size_t f = 0; f < poses.frames; ++f) {
    const std::vector<float> positions = evaluator.positions({&poses.controls[f * width], width});
    if (f == 0) low = high = positions;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      low[i] = std::min(low[i], positions[i]);
      high[i] = std::max(high[i], positions[i]);
    }
  }
  std::array<std::vector<float>, 8> corners;
  for (std::size_t corner = 0; corner < corners.size(); ++corner) {
    corners[corner] = low;
    for (std::size_t i = 0; i < low.size(); ++i)
      if (corner >> i % 3 & 1) corners[corner][i] = high[i];
  }
  return corners;
}

void print_notes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) print_line(note, "facebaker pose: ");
}

void PoseCommand::write_still(const std::string& path, const CharacterView& character, const PoseRenderer* renderer,
                              const std::vector<float>& positions, const std::vector<float>& reference) {
  if (!renderer) {
    write_obj(path, character, positions);
  } else if (reference.empty()) {
    write_png(path, renderer->draw(positions));
  } else {
    const auto comparison =
        renderer->draw_comparison({"true rig", reference}, {{"archive", positions}}, {{error_scale}});
    write_png(path, comparison.image);
    worst_ = std::max(worst_, comparison.differences[0].max);
  }
  files_.push_back(path);
}

void PoseCommand::write_stills(PoseEvaluator& evaluator, const Poses& poses) {
  const facebaker::Model& model = evaluator.model();
  const std::size_t width = model.control_count();
  std::vector<std::string> notes;
  std::optional<facebaker::Source> reference;
  if (!beside.empty()) reference = open_beside(beside, rigs, model, archive, notes);
  std::optional<PoseRenderer> renderer;
  if (file_extension(out) == ".png") {
    const std::array<std::vector<float>, 8> bounds = bounds_of(evaluator, poses);
    if (!whole) view.region = moving_region(evaluator);
    renderer.emplace(evaluator.character().mesh, MeshPoses{bounds.begin(), bounds.end()}, fb_up_axis(model.get()), view,
                     resolution_from(size), parallel, appearance_of(evaluator.character(), &notes));
  }
  print_notes(notes);
  ProgressBar progress;
  if (poses.frames > 1) progress.begin(Phase::writing, "writing frames", poses.frames);
  for (std::size_t f = 0; f < poses.frames; ++f) {
    const float* controls = &poses.controls[f * width];
    std::vector<float> expected;
    if (reference) expected = facebaker::SourceView(*reference).evaluate(controls, 1);
    write_still(numbered(out, f, poses.frames > 1), evaluator.character(), renderer ? &*renderer : nullptr,
                evaluator.positions({controls, width}), expected);
    progress.step(f + 1);
  }
}

void PoseCommand::print(const Poses& poses) const {
  if (json) {
    nlohmann::ordered_json figures = {{"files", files_}, {"frames", poses.frames}, {"clamped", poses.clamped}};
    if (expected_) figures["expected_error"] = expected_->largest, figures["outside"] = expected_->outside;
    if (!beside.empty()) figures["max"] = worst_;
    if (rights_->stated()) figures["rights"] = rights_->document();
    if (summary_) summary_->add_to(figures);
    // Bytes that are no UTF-8, as file names may have, are replaced.
    print_result(figures.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
    return;
  }
  for (const std::string& file : files_) print_result(file + "\n");
  if (summary_) print_result(summary_->text());
  if (!beside.empty()) print_result(format("largest distance from the true rig: %.2e of the diagonal\n", worst_));
}

void PoseCommand::check_options() const {
  const std::string form = file_extension(out);
  const bool picture = form == ".png";
  if (form != ".glb" && !picture && form != ".obj")
    fail(Status::invalid_argument, "--out %s: the name must end in .glb, .obj or .png", shown(out).c_str());
  if (!beside.empty() && !picture) fail(Status::invalid_argument, "--beside needs a picture: --out NAME.png");
  if (lod > 0 && form == ".glb")
    fail(Status::invalid_argument, "--lod needs --out NAME.obj or NAME.png: morph targets are those of the whole");
  if (frame && request.animation().empty()) fail(Status::invalid_argument, "--frame needs --clip or --livelink");
  scene.check(form == ".glb");
}

Poses PoseCommand::read_frames(const facebaker::Model& model) const {
  Poses poses = read_poses(request, model);
  if (!frame) return poses;
  if (*frame >= poses.frames)
    fail(Status::invalid_argument, "--frame %zu: %s has frames 0 to %zu", *frame, shown(request.animation()).c_str(),
         poses.frames - 1);
  const auto first = poses.controls.begin() + static_cast<std::ptrdiff_t>(*frame * model.control_count());
  poses.controls = std::vector<float>(first, first + model.control_count());
  poses.frames = 1;
  return poses;
}

void PoseCommand::run() {
  check_options();
  const facebaker::Model model(archive);
  const OutputLock lock = OutputLock::of_file(out);
  const Poses poses = read_frames(model);
  print_notes(poses.notes);
  rights_.emplace(fb_about(model.get()));
  if (!rights_->note().empty()) print_notes({rights_->note()});
  expected_ = expect_errors(model, poses);
  if (expected_)
    if (const auto warning = outside_warning(*expected_, poses.frames)) print_notes({*warning});
  PoseEvaluator evaluator(model, parallel, lod);
  if (file_extension(out) == ".glb") {
    summary_ = write_scene(evaluator, poses, scene, out);
    print_notes(summary_->notes);
    files_.push_back(out);
  } else {
    write_stills(evaluator, poses);
  }
  print(poses);
}

// Options that matter for images only.
void add_image_options(Command app, PoseCommand& command) {
  app.add_option("--beside", command.beside,
                 "A rig plugin, a .glb or .gltf, or \"sample\": show the true rig, the archive and the error side by "
                 "side (.png)")
      .type_name("SOURCE");
  app.add_option("--yaw", command.view.yaw, "Turn of the camera around the head, degrees, for .png").shows_default();
  app.add_option("--pitch", command.view.pitch, "Elevation of the camera, degrees, for .png")
      .between(-89.0, 89.0)
      .shows_default();
  app.add_flag("--whole", command.whole,
               "Show all of a body; by default, where controls move a small part of the mesh, the picture is of that "
               "part, for .png");
  app.add_option("--size", command.size, "Size of a picture's panel, for .png")
      .type_name("WIDTHxHEIGHT")
      .shows_default();
  app.add_option("--error-scale", command.error_scale,
                 "Error at the end of the error map's scale, over the diagonal; 0: a round number above the largest")
      .between(0.0, 1.0)
      .shows_default();
}

}  // namespace

void add_pose(Command tool) {
  auto command = std::make_shared<PoseCommand>();
  const Command app = tool.add_command("pose", "Pose a face and write it as .glb, .obj or .png");
  add_archive(app, command->archive);
  app.add_option("--set", command->request.set,
                 "A control's value (repeatable); all others are at rest, or as in the clip. A value outside the "
                 "control's range is clamped, with a note")
      .type_name("NAME=VALUE")
      .repeatable();
  const Option clip = app.add_option("--clip", command->request.clip, "Animation: a NumPy file of frames x controls")
                          .type_name("FILE.npy");
  app.add_option("--livelink", command->request.live_link,
                 "Animation: a recording of Live Link Face; its columns drive the controls with their ARKit names")
      .type_name("FILE.csv")
      .not_with(clip);
  app.add_option("--frame", command->frame, "Only this frame of the animation, counted from 0")
      .checked(whole_number)
      .type_name("N");
  app.add_option(
         "--out", command->out,
         "File to write: .glb (meshes, materials, skin and sockets; an animation by morph targets), .obj (polygons in "
         "the "
         "rig's own order) or .png (shaded picture). The frames of an animation become NAME.0000.obj or .png and so on")
      .type_name("FILE")
      .required();
  app.add_option("--lod", command->lod,
                 "Level of detail, for .obj and .png: 0 is the whole, 1, 2, ... are coarser levels; in between, "
                 "vertices slide from one to the next")
      .between(0.0f, 15.0f)
      .type_name("X")
      .shows_default();
  app.add_option("--fps", command->request.fps,
                 "Frames a second: of --clip, for .glb (default 30); to which --livelink is resampled (default: as "
                 "recorded)")
      .between(1.0, 1000.0);
  command->scene.add_to(app);
  add_image_options(app, *command);
  command->rigs.add_to(app);
  add_threads(app, command->parallel);
  add_json_flag(app, command->json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
