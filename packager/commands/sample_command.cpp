#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "bake/dataset/open_source.h"
#include "bake/sampling/sampling.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/json_text.h"
#include "commands/progress_bar.h"

namespace fb::tool {
using namespace bake;
namespace {

struct SampleCommand {
  std::string source, out;
  SamplingOptions options;
  std::vector<std::string> clips;
  Parallel parallel;
  bool json = false, no_shots = false;

  void run();
};

void SampleCommand::run() {
  const auto rig = open_source(source);
  if (!rig->live())
    fail(Status::invalid_argument,
         "%s: a recording cannot be asked for new poses; give a rig plugin, a glTF file or \"sample\"", source.c_str());
  for (const std::string& clip : clips) {
    const std::size_t equals = clip.find('=');
    if (equals == 0 || equals == std::string::npos)
      fail(Status::invalid_argument, "--clip %s: give NAME=controls.npy", clip.c_str());
    options.extra.push_back(read_clip(clip.substr(0, equals), clip.substr(equals + 1), rig->schema()));
  }
  options.shots = !no_shots;
  SampleReport report;
  {
    ProgressBar progress;
    RigEvaluator evaluator(*rig, parallel);
    report = sample(evaluator, options, out, progress);
  }
  if (json)
    std::fputs(json_text({{"dataset", out},
                          {"poses", report.poses},
                          {"evaluated", report.evaluated},
                          {"rig_calls", report.rig_calls}})
                   .c_str(),
               stdout);
  else
    std::printf("%s: %zu poses, %zu of them evaluated now, in %llu rig calls\n", out.c_str(), report.poses,
                report.evaluated, static_cast<unsigned long long>(report.rig_calls));
}

}  // namespace

void add_sample(CLI::App& tool) {
  auto command = std::make_shared<SampleCommand>();
  CLI::App* app = tool.add_subcommand("sample", "Ask a rig for training poses and write them as a dataset folder");
  app->add_option(
         "SOURCE", command->source,
         "A rig plugin (librig_NAME.so), a .glb or .gltf with morph targets, or \"sample\" for the built-in face")
      ->required();
  app->add_option("--out", command->out, "The dataset folder to write; one begun with the same options is continued")
      ->type_name("DIR")
      ->required();
  add_poses(*app, command->options.poses, command->options.rig_budget);
  add_mix(*app, command->options.mix);
  app->add_option("--clip", command->clips,
                  "A clip of your own to evaluate as well: controls in a NumPy file of frames x "
                  "controls (repeatable)")
      ->type_name("NAME=FILE.npy")
      ->allow_extra_args(false);
  app->add_flag("--no-shots", command->no_shots, "Leave the rig's own clips out");
  add_seed(*app, command->options.seed);
  add_threads(*app, command->parallel);
  add_json_flag(*app, command->json);
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
