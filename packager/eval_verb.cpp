#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "archive/reader.h"
#include "bake/measure/evaluate.h"
#include "base/file.h"
#include "figure_outputs.h"
#include "pose_animation.h"
#include "progress_bar.h"
#include "render/png_file.h"
#include "render/portrait.h"
#include "report_json.h"
#include "table.h"
#include "verb_options.h"
#include "verbs.h"

namespace fb {
namespace {

struct EvalVerb {
  std::string archive, split = "test";
  std::vector<std::string> sources;
  FigureOutputs outputs;
  Parallel parallel;

  void run();
};

std::string eval_text(const EvalReport& report) {
  Table table({"clip", "kind", "split", "frames", "mse", "rms", "mean", "p99", "max", "mfm"});
  const auto add = [&](const std::string& name, const char* kind, const char* split, const Errors& e) {
    std::vector<std::string> row = {name, kind, split, std::to_string(e.frames)};
    for (const double figure : {e.mse, e.rms, e.mean, e.p99, e.max, e.mfm}) row.push_back(format("%.2e", figure));
    table.add(std::move(row));
  };
  for (const ClipErrors& clip : report.clips) add(clip.name, name_of(clip.kind), name_of(clip.split), clip.errors);
  add("total", "", "", report.total);
  const TouchedBytes& touched = report.touched;
  return table.text() +
         format("All errors are fractions of the rest mesh's diagonal, %g %s.\n", report.diagonal,
                report.units.c_str()) +
         format("A pose reads %.0f bytes of the model on average, 95 of 100 at most %llu.\n", touched.mean,
                static_cast<unsigned long long>(touched.p95));
}

// The frame with the largest error of all: the true rig, the archive, and where they differ.
void write_worst_frame(const std::string& folder, const PackedModel& model, Source& source, const EvalReport& report,
                       const Parallel& parallel) {
  const auto worst = std::max_element(report.clips.begin(), report.clips.end(),
                                      [](const auto& a, const auto& b) { return a.errors.max < b.errors.max; });
  const auto& clips = source.clips();
  const auto clip = std::find_if(clips.begin(), clips.end(), [&](const Clip& c) { return c.name == worst->name; });
  if (worst == report.clips.end() || clip == clips.end()) return;
  const std::size_t width = model.schema.control_count();
  const std::span<const float> controls(&clip->controls[worst->errors.worst_frame * width], width);
  std::vector<float> truth(model.rest.points.size());
  source.read(static_cast<std::size_t>(clip - clips.begin()), worst->errors.worst_frame, 1, truth);
  const Portrait portrait(model.rest, model.schema.up_axis, {}, {}, parallel);
  const auto predicted = evaluate_frames(Evaluator(model), controls, parallel);
  write_png(folder + "/worst.png", portrait.draw_beside(truth, predicted, 0).image);
}

void EvalVerb::run() {
  const auto bytes = read_file(archive);
  const PackedModel model = naming(archive, [&] { return read_archive(bytes).model; });
  const auto source = open_sources(sources);
  outputs.check();
  std::optional<Split> only;
  if (split != "all") only = split_from(split);
  EvalReport result;
  {
    ProgressBar progress;
    for (const std::string& note : source->notes()) progress.note(note);
    result = evaluate_archive(bytes, *source, only, parallel, progress);
  }
  outputs.write("eval", eval_json(archive, result), eval_text(result));
  if (!outputs.report.empty()) write_worst_frame(outputs.report, model, *source, result, parallel);
}

}  // namespace

void add_eval(CLI::App& tool) {
  auto verb = std::make_shared<EvalVerb>();
  CLI::App* app = tool.add_subcommand("eval", "Measure an archive against the true rig");
  add_archive(*app, verb->archive);
  add_sources(*app, verb->sources);
  app->add_option("--split", verb->split, "Which clips to measure on")
      ->check(CLI::IsMember({"train", "validation", "test", "all"}))
      ->capture_default_str();
  verb->outputs.add_to(*app, ", and a picture of the worst frame");
  add_threads(*app, verb->parallel);
  app->callback([verb] { verb->run(); });
}

}  // namespace fb
