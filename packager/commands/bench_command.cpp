#include <cmath>
#include <memory>
#include <optional>

#include "base/file.h"
#include "base/output_lock.h"
#include "base/random_streams.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "bench/speed.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/pose_controls.h"
#include "commands/progress_bar.h"
#include "commands/rig_options.h"
#include "commands/speed_text.h"

namespace fb::tool {
namespace {

struct BenchCommand {
  std::string archive, csv;
  std::vector<std::string> sources;
  std::size_t poses = 400;
  SpeedOptions options;
  RigOptions rigs;
  FigureOutputs outputs;

  void run();

 private:
  std::vector<float> recorded_clip(const facebaker::Model& model) const;
};

// A synthetic shot: one control in five follows a sine wave over its range, each with a frequency of its own.
std::vector<float> synthetic_clip(const facebaker::Model& model, std::size_t poses) {
  const std::vector<fb_control> controls = controls_of(model);
  Random random = open_stream(1, Stream::bench_clip);
  std::vector<float> values;
  for (std::size_t pose = 0; pose < poses; ++pose)
    for (const fb_control& control : controls) values.push_back(control.rest);
  for (std::size_t c = 0; c < controls.size(); ++c) {
    const fb_control& control = controls[c];
    const float frequency = random.uniform(0.02f, 0.2f), phase = random.uniform(0, 6.28f);
    if (random.uniform() >= 0.2f) continue;
    for (std::size_t pose = 0; pose < poses; ++pose) {
      const float share = 0.5f + 0.5f * std::sin(frequency * float(pose) + phase);
      values[pose * controls.size() + c] = control.minimum + share * (control.maximum - control.minimum);
    }
  }
  return values;
}

// The first frames of the source's test clips.
std::vector<float> BenchCommand::recorded_clip(const facebaker::Model& model) const {
  std::vector<std::string> notes;
  const facebaker::Source opened = rigs.open(sources, notes);
  const facebaker::SourceView source(opened);
  source.check_model(model);
  std::vector<float> values;
  for (std::uint32_t c = 0; c < source.info().clip_count; ++c) {
    const fb_clip clip = source.clip(c);
    if (clip.split == FB_SPLIT_TEST)
      values.insert(values.end(), clip.controls, clip.controls + clip.frames * model.control_count());
  }
  if (values.empty())
    fail(Status::invalid_argument, "%s: has no test clips; without --source, a synthetic shot is posed",
         shown(sources.front()).c_str());
  values.resize(std::min(values.size(), poses * model.control_count()));
  return values;
}

void BenchCommand::run() {
  const facebaker::Archive face(archive);
  std::optional<OutputLock> lock;
  if (!csv.empty()) lock = OutputLock::of_file(csv);
  outputs.claim();
  const fb_archive_info info = face.info();
  const facebaker::Model model(info.bytes, info.byte_count);
  const std::vector<float> controls = sources.empty() ? synthetic_clip(model, poses) : recorded_clip(model);
  Speed speed;
  {
    ProgressBar progress;
    speed = measure_speed(face, controls, options, progress);
  }
  if (!csv.empty()) write_file(csv, speed_csv(speed));
  outputs.write("bench", speed_json(speed), speed_text(speed));
}

}  // namespace

void add_bench(Command tool) {
  auto command = std::make_shared<BenchCommand>();
  const Command app = tool.add_command("bench", "Measure how long an archive's poses take, beside float networks");
  add_archive(app, command->archive);
  app.add_option("--source", command->sources,
                 "Source whose test clips are posed, frame by frame; without it, a synthetic shot")
      .type_name("SOURCE");
  const auto add_count = [&](const char* name, std::size_t& number, const char* what) {
    app.add_option(name, number, what).between(std::uint64_t{1}, std::uint64_t{1} << 20).type_name("N").shows_default();
  };
  add_count("--poses", command->poses, "Frames to pose, at most");
  add_count("--rounds", command->options.rounds, "How often each of them is measured");
  add_count("--batch", command->options.batch, "Poses of a batch");
  add_count("--crowd", command->options.crowd, "Faces of a crowd");
  add_count("--instances", command->options.instances, "Instances of the face that are posed together, with normals");
  command->rigs.add_to(app);
  app.add_option("--csv", command->csv, "Write the figures to this file too, as comma-separated values");
  command->outputs.add_json_to(app);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
