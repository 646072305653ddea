#include <facebaker/facebaker_bake.hpp>
#include <memory>

#include "base/shown_path.h"
#include "base/status.h"
#include "commands/clip_files.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/library_options.h"
#include "commands/progress_bar.h"
#include "commands/results.h"
#include "commands/rig_options.h"

namespace fb::tool {
namespace {

struct SampleCommand {
  SampleCommand() { fb_sample_desc_init(&desc); }

  std::string source, out, mix = "dense";
  fb_sample_desc desc;
  std::vector<std::string> poses_like;
  std::vector<std::string> clips;  // "NAME=FILE.npy"
  Parallel parallel;
  RigOptions rigs;
  bool json = false, no_shots = false, skip_failing = false;

  void run();
};

void SampleCommand::run() {
  std::vector<std::string> notes;
  const facebaker::Source opened = rigs.open({source}, notes, desc.rig_budget);
  const facebaker::SourceView rig(opened);
  if (!rig.live())
    fail(Status::invalid_argument, "%s: a recording has no new poses; give a rig plugin, a glTF file or \"sample\"",
         shown(source).c_str());
  ClipFiles files;
  files.read(clips, rig.info().control_count);
  const std::vector<const char*> examples = c_strings(poses_like);
  desc.source = opened.get();
  desc.examples = examples.data();
  desc.example_count = static_cast<std::uint32_t>(examples.size());
  desc.directory = out.c_str();
  desc.mix = mix.c_str();
  desc.shots = no_shots ? 0 : 1;
  desc.skip_failing = skip_failing ? 1 : 0;
  desc.threads = static_cast<std::uint32_t>(parallel.threads);
  desc.clips = files.clips().data();
  desc.clip_count = static_cast<std::uint32_t>(files.clips().size());
  const facebaker::Report report = [&] {
    ProgressBar progress;
    for (const std::string& note : notes) progress.note(note);
    desc.callbacks = progress.callbacks();
    return facebaker::sample(desc);
  }();
  if (json) {
    print_result(report.json().c_str());
    return;
  }
  fb_sample_result result;
  fb_sample_result_init(&result);
  facebaker::check(fb_report_sample(report.get(), &result));
  print_result(format("%s: %llu poses, %llu of them evaluated now, in %llu rig calls\n", out.c_str(),
                      static_cast<unsigned long long>(result.poses), static_cast<unsigned long long>(result.evaluated),
                      static_cast<unsigned long long>(result.rig_calls)));
  if (result.left_out > 0)
    print_result(format("%llu poses failed and are left out\n", static_cast<unsigned long long>(result.left_out)));
}

}  // namespace

void add_sample(Command tool) {
  auto command = std::make_shared<SampleCommand>();
  const Command app = tool.add_command("sample", "Evaluate a rig in training poses and write them as a dataset folder");
  app.add_option("SOURCE", command->source,
                 "A rig plugin (librig_NAME.so), a .glb or .gltf with morph targets, exec:COMMAND for a program that "
                 "speaks the "
                 "rig protocol, or \"sample\" for the built-in face")
      .required();
  app.add_option("--out", command->out, "The dataset folder to write; one begun with the same options is continued")
      .type_name("DIR")
      .required();
  add_poses(app, command->desc.poses, command->desc.rig_budget);
  add_library_option(app, "mix", command->mix);
  add_poses_like(app, command->poses_like);
  add_clip_files(app, command->clips);
  app.add_flag("--no-shots", command->no_shots, "Leave out the rig's own clips");
  add_library_option(app, "seed", command->desc.seed);
  app.add_flag(
      "--skip-failing-poses", command->skip_failing,
      "Put the rest pose in the place of drawn poses that the rig cannot evaluate, up to a tenth of all, instead "
      "of failing; poses of clips, and of controls moved alone, still have to succeed");
  command->rigs.add_clip_budget_to(app);
  command->rigs.add_to(app);
  add_threads(app, command->parallel);
  add_json_flag(app, command->json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
