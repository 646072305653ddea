#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/rig/pose_set.h"
#include "base/file.h"
#include "base/random.h"
#include "bench/speed.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/progress_bar.h"
#include "commands/speed_text.h"

namespace fb::tool {
using namespace archive;
using namespace bake;
namespace {

struct BenchCommand {
  std::string archive, csv;
  std::vector<std::string> sources;
  std::size_t poses = 400;
  SpeedOptions options;

  void run() const;

 private:
  std::vector<float> recorded(const RigSchema& schema) const;
};

// A shot nobody acted: one control in five swings to and fro, each at its own pace.
std::vector<float> made_up(const RigSchema& schema, std::size_t poses) {
  Random random(1);
  std::vector<float> controls;
  for (std::size_t pose = 0; pose < poses; ++pose)
    for (const Control& control : schema.controls) controls.push_back(control.rest);
  for (std::size_t c = 0; c < schema.control_count(); ++c) {
    const Control& control = schema.controls[c];
    const float pace = random.uniform(0.02f, 0.2f), phase = random.uniform(0, 6.28f);
    if (random.uniform() >= 0.2f) continue;
    for (std::size_t pose = 0; pose < poses; ++pose) {
      const float share = 0.5f + 0.5f * std::sin(pace * float(pose) + phase);
      controls[pose * schema.control_count() + c] = control.minimum + share * (control.maximum - control.minimum);
    }
  }
  return controls;
}

std::vector<float> BenchCommand::recorded(const RigSchema& schema) const {
  const auto source = open_sources(sources);
  check_same_controls(schema, "the archive", source->schema(), "the source");
  const PoseSet shots(*source, [](const Clip& clip) { return clip.split == Split::test; });
  std::vector<float> controls = shots.controls();
  controls.resize(std::min(shots.size(), poses) * schema.control_count());
  return controls;
}

void BenchCommand::run() const {
  const std::vector<std::byte> bytes = read_file(archive);
  const RigSchema schema = with_context(archive, [&] { return read_archive(bytes).model.schema; });
  const std::vector<float> controls = sources.empty() ? made_up(schema, poses) : recorded(schema);
  Speed speed;
  {
    ProgressBar progress;
    speed = measure_speed(bytes, controls, options, progress);
  }
  if (!csv.empty()) write_file(csv, speed_csv(speed));
  std::fputs(speed_text(speed).c_str(), stdout);
}

}  // namespace

void add_bench(CLI::App& tool) {
  auto command = std::make_shared<BenchCommand>();
  CLI::App* app = tool.add_subcommand("bench", "Measure how long an archive's poses take, beside float networks");
  add_archive(*app, command->archive);
  app->add_option("--source", command->sources, "Whose test clips are posed, frame by frame; without, a made-up shot")
      ->type_name("SOURCE");
  const CLI::Range count(std::size_t{1}, std::size_t{1} << 20);
  const auto add_count = [&](const char* name, std::size_t& number, const char* what) {
    app->add_option(name, number, what)->check(count)->type_name("N")->capture_default_str();
  };
  add_count("--poses", command->poses, "Frames that are posed, at most");
  add_count("--rounds", command->options.rounds, "How often each of them is");
  add_count("--batch", command->options.batch, "Poses of a batch");
  app->add_option("--csv", command->csv, "Write the figures to this file too, as comma-separated values");
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
