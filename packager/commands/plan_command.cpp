#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <optional>

#include "base/file_extension.h"
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

struct PlanCommand {
  PlanCommand() { fb_sample_desc_init(&desc); }

  std::string source, out, mix = "dense";
  fb_sample_desc desc;
  std::vector<std::string> poses_like;
  std::vector<std::string> clips;  // "NAME=FILE.npy"
  Parallel parallel;
  RigOptions rigs;
  bool json = false, no_shots = false;

  void run();
};

void PlanCommand::run() {
  std::vector<std::string> notes;
  std::optional<facebaker::Source> opened;
  const bool is_schema = file_extension(source) == ".json";
  if (!is_schema) opened.emplace(rigs.open({source}, notes));
  if (is_schema && !clips.empty())
    fail(Status::invalid_argument,
         "--clip: clips of a schema are planned by hand: name their controls in dataset.json");
  ClipFiles files;
  if (opened) files.read(clips, facebaker::SourceView(*opened).info().control_count);
  const std::vector<const char*> examples = c_strings(poses_like);
  desc.source = opened ? opened->get() : nullptr;
  desc.schema = is_schema ? source.c_str() : nullptr;
  desc.examples = examples.data();
  desc.example_count = static_cast<std::uint32_t>(examples.size());
  desc.directory = out.c_str();
  desc.mix = mix.c_str();
  desc.shots = no_shots ? 0 : 1;
  desc.threads = static_cast<std::uint32_t>(parallel.threads);
  desc.clips = files.clips().data();
  desc.clip_count = static_cast<std::uint32_t>(files.clips().size());
  const facebaker::Report report = [&] {
    ProgressBar progress;
    for (const std::string& note : notes) progress.note(note);
    desc.callbacks = progress.callbacks();
    return facebaker::plan(desc);
  }();
  if (json) {
    print_result(report.json().c_str());
    return;
  }
  fb_sample_result result;
  fb_sample_result_init(&result);
  facebaker::check(fb_report_sample(report.get(), &result));
  print_result(format("%s: %llu poses to evaluate; dataset.json names the files of points to write\n", out.c_str(),
                      static_cast<unsigned long long>(result.poses)));
}

}  // namespace

void add_plan(Command tool) {
  auto command = std::make_shared<PlanCommand>();
  const Command app =
      tool.add_command("plan", "Write the poses that a program should evaluate as a dataset folder without points");
  app.add_option(
         "SOURCE", command->source,
         "Whose controls the poses are of: a schema, which is a .json file like dataset.json that needs neither "
         "rest mesh nor clips, or any source")
      .required();
  app.add_option("--out", command->out, "The dataset folder to write").type_name("DIR").required();
  add_pose_count(app, command->desc.poses,
                 "Poses to train on; by default 20000. A fifth, at most 2,000, come on top to measure on");
  add_library_option(app, "mix", command->mix);
  add_poses_like(app, command->poses_like);
  add_clip_files(app, command->clips);
  app.add_flag("--no-shots", command->no_shots, "Leave out the rig's own clips");
  add_library_option(app, "seed", command->desc.seed);
  command->rigs.add_clip_budget_to(app);
  command->rigs.add_to(app);
  add_threads(app, command->parallel);
  add_json_flag(app, command->json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
