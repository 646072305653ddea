#include <facebaker/facebaker_bake.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/file_extension.h"
#include "base/output_lock.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/export_blendshapes.h"
#include "commands/export_skinned.h"
#include "commands/face_rights.h"
#include "commands/library_options.h"
#include "commands/pose_controls.h"
#include "commands/pose_evaluator.h"
#include "commands/progress_bar.h"
#include "commands/results.h"
#include "commands/target_limits.h"
#include "commands/terminal.h"
#include "export/low_rank.h"
#include "export/point_cache_writer.h"
#include "export/usda_file.h"

namespace fb::tool {
namespace {

// Options that only some forms have, by the extensions of those.
struct FormOption {
  Option option;
  std::vector<std::string> extensions;
};

struct ExportCommand {
  std::string archive, out;
  PoseRequest request;
  std::optional<std::size_t> shapes;
  bool skinned = false, arkit_names = false, json = false;
  std::uint32_t joints = SkinnedExport().joints;
  TargetOptions targets;
  std::uint64_t poses = BlendshapeExport().poses, seed = 1;
  Parallel parallel;
  std::vector<FormOption> form_options;
  std::vector<Option> skinned_options, plain_options;

  void run();

 private:
  std::string extension() const { return file_extension(out); }
  void check_options() const;
  ExportResult write(const facebaker::Archive& opened) const;
  ExportResult write_moving(const facebaker::Archive& opened, const facebaker::Model& model) const;
  ExportResult write_points(PoseEvaluator& evaluator, const facebaker::Archive& opened, const Poses& frames) const;
};

void ExportCommand::check_options() const {
  static const std::vector<std::string> known = {".glb", ".onnx", ".mdd", ".pc2", ".usda"};
  const std::string form = extension();
  if (std::ranges::find(known, form) == known.end())
    fail(Status::invalid_argument, "%s: the name must end in .glb, .onnx, .mdd, .pc2 or .usda", shown(out).c_str());
  for (const FormOption& one : form_options)
    if (one.option.given() && std::ranges::find(one.extensions, form) == one.extensions.end())
      fail(Status::invalid_argument, "%s has no effect on a %s", one.option.name().c_str(), form.c_str());
  for (const Option& option : skinned_options)
    if (option.given() && !skinned) fail(Status::invalid_argument, "%s needs --skinned", option.name().c_str());
  for (const Option& option : plain_options)
    if (option.given() && skinned)
      fail(Status::invalid_argument, "%s has no effect with --skinned", option.name().c_str());
  if ((form == ".mdd" || form == ".pc2") && request.animation().empty())
    fail(Status::invalid_argument, "a %s has frames of an animation: give --clip or --livelink", form.c_str());
  if (skinned && !request.set.empty() && request.animation().empty())
    fail(Status::invalid_argument, "--set needs --clip or --livelink with --skinned: the file rests");
}

// Point caches and .usda: positions frame by frame.
ExportResult ExportCommand::write_points(PoseEvaluator& evaluator, const facebaker::Archive& opened,
                                         const Poses& frames) const {
  ProgressBar progress;
  ExportResult result;
  const CharacterView& character = evaluator.character();
  const std::size_t width = evaluator.model().control_count();
  const FrameReader positions = [&](std::size_t first, std::size_t count) {
    return evaluator.positions(std::span(frames.controls).subspan(first * width, count * width));
  };
  if (extension() == ".usda") {
    progress.begin(Phase::writing, "writing frames", frames.frames * character.meshes.size());
    const fb_archive_info info = opened.info();
    result.notes = write_usda(out, {character, frames.frames, frames.fps, positions, info.licence, info.about},
                              [&](std::size_t done) { progress.step(done); });
  } else {
    progress.begin(Phase::writing, "writing frames", frames.frames);
    PointCacheWriter file(out, extension() == ".mdd" ? PointCache::mdd : PointCache::pc2, frames.frames,
                          character.mesh.vertex_count(), frames.fps);
    for_frame_blocks(positions, frames.frames, [&](std::size_t first, std::size_t count, std::span<const float> block) {
      file.add(block);
      progress.step(first + count);
    });
    file.finish();
  }
  result.lines.push_back(format("%zu frames of %zu vertices", frames.frames, character.mesh.vertex_count()));
  result.figures["vertices"] = character.mesh.vertex_count();
  return result;
}

ExportResult ExportCommand::write_moving(const facebaker::Archive& opened, const facebaker::Model& model) const {
  const Poses frames = read_poses(request, model);
  for (const std::string& note : frames.notes) print_line(note, "facebaker export: ");
  PoseEvaluator evaluator(model, parallel);
  ExportResult result;
  if (extension() != ".glb") {
    result = write_points(evaluator, opened, frames);
  } else if (skinned) {
    SkinnedExport options;
    options.joints = joints;
    options.shapes = shapes.value_or(options.shapes);
    options.arkit_names = arkit_names;
    options.poses = poses;
    options.seed = seed;
    options.licence = opened.info().licence;
    result = export_skinned(evaluator, opened, frames, options, out);
  } else {
    BlendshapeExport options;
    options.shapes = shapes.value_or(options.shapes);
    options.arkit_names = arkit_names;
    options.targets = targets;
    options.poses = poses;
    options.seed = seed;
    options.licence = opened.info().licence;
    ProgressBar progress;
    result = export_blendshapes(evaluator, frames, options, out, progress);
  }
  result.figures["frames"] = frames.frames;
  result.figures["clamped"] = frames.clamped;
  result.figures["units"] = evaluator.character().units;
  return result;
}

ExportResult write_onnx_model(const facebaker::Archive& opened, const facebaker::Model& model, const std::string& out) {
  ExportResult result;
  fb_report* handle = nullptr;
  facebaker::check(fb_export_onnx(opened.get(), out.c_str(), &handle));
  const std::unique_ptr<fb_report, void (*)(fb_report*)> report(handle, fb_report_free);
  const auto document = nlohmann::json::parse(fb_report_json(report.get()));
  result.figures["nodes"] = document["nodes"];
  result.figures["parameters"] = document["parameters"];
  result.lines.push_back(format("controls [n, %zu] to positions [n, %zu, 3]: %zu nodes, %zu parameters",
                                std::size_t(model.control_count()), std::size_t(model.vertex_count()),
                                document["nodes"].get<std::size_t>(), document["parameters"].get<std::size_t>()));
  if (const std::uint32_t sockets = fb_socket_count(model.get()))
    result.notes.push_back(format("%u sockets are left out", sockets));
  if (fb_level_count(model.get()) > 1) result.notes.emplace_back("levels of detail are left out: it is the whole face");
  return result;
}

ExportResult ExportCommand::write(const facebaker::Archive& opened) const {
  const fb_archive_info info = opened.info();
  const facebaker::Model model(info.bytes, info.byte_count);
  if (extension() == ".onnx") return write_onnx_model(opened, model, out);
  return write_moving(opened, model);
}

void ExportCommand::run() {
  check_options();
  const facebaker::Archive opened(archive);
  const OutputLock lock = OutputLock::of_file(out);
  const FaceRights rights(opened.info().about);
  ExportResult result = write(opened);
  if (!rights.note().empty()) result.notes.insert(result.notes.begin(), rights.note());
  for (const std::string& note : result.notes) print_line(note, "facebaker export: ");
  if (json) {
    nlohmann::ordered_json figures = {{"file", out}};
    figures.update(result.figures);
    if (rights.stated()) figures["rights"] = rights.document();
    // Bytes that are no UTF-8, as file names may have, are replaced.
    print_result(figures.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
    return;
  }
  print_result(out + "\n");
  for (const std::string& line : result.lines) print_result(line + "\n");
}

void add_moving_options(Command app, ExportCommand& command) {
  const std::vector<std::string> moving = {".glb", ".mdd", ".pc2", ".usda"}, glb = {".glb"};
  const auto only = [&](const Option& option, const std::vector<std::string>& extensions) {
    command.form_options.push_back({option, extensions});
    return option;
  };
  const Option clip =
      only(app.add_option("--clip", command.request.clip, "Animation: a NumPy file of frames x controls; not for .onnx")
               .type_name("FILE.npy"),
           moving);
  only(app.add_option("--livelink", command.request.live_link,
                      "Animation: a recording of Live Link Face; its columns drive the controls with their ARKit names")
           .type_name("FILE.csv")
           .not_with(clip),
       moving);
  only(app.add_option("--set", command.request.set,
                      "A control's value, in all frames (repeatable); all others are at rest, or as in the clip")
           .type_name("NAME=VALUE")
           .repeatable(),
       moving);
  only(
      app.add_option("--fps", command.request.fps,
                     "Frames a second: of --clip (default 30); to which --livelink is resampled (default: as recorded)")
          .between(1.0, 1000.0),
      moving);
}

void add_glb_options(Command app, ExportCommand& command) {
  const auto only_glb = [&](const Option& option) {
    command.form_options.push_back({option, {".glb"}});
    return option;
  };
  only_glb(
      app.add_option("--shapes", command.shapes,
                     "Blendshapes at most, the strongest ones: of ends of controls (default 64), or with --skinned "
                     "of what the joints leave (default 16); for .glb")
          .checked(whole_number)
          .type_name("K"));
  only_glb(
      app.add_flag("--arkit-names", command.arkit_names, "Name blendshapes by ARKit where controls say so (.glb)"));
  for (const Option& option : command.targets.add_to(app)) command.plain_options.push_back(only_glb(option));
  only_glb(app.add_flag("--skinned", command.skinned,
                        "Joints with four skin weights a vertex and a few blendshapes, for engines that take nothing "
                        "else (.glb)"));
  command.skinned_options.push_back(
      only_glb(app.add_option("--joints", command.joints, "Joints at most, with --skinned")
                   .between(1, 1024)
                   .type_name("N")
                   .shows_default()));
  only_glb(app.add_option("--poses", command.poses,
                          "Random poses that shapes are chosen by, joints are fitted to, and errors measured on (.glb)")
               .between(1, 10000)
               .type_name("N")
               .shows_default());
}

}  // namespace

void add_export(Command tool) {
  auto command = std::make_shared<ExportCommand>();
  const Command app = tool.add_command("export", "Write a face in another form: .glb, .onnx, .mdd, .pc2 or .usda");
  add_archive(app, command->archive);
  app.add_option(
         "OUT", command->out,
         "File to write: .glb (blendshapes named as controls, or --skinned; an animation of --clip), .onnx (the "
         "whole face as a network), .mdd or .pc2 (point caches of --clip), .usda (USD as text, points of --clip)")
      .type_name("FILE")
      .required();
  add_moving_options(app, *command);
  add_glb_options(app, *command);
  add_library_option(app, "seed", command->seed);
  add_threads(app, command->parallel);
  add_json_flag(app, command->json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
