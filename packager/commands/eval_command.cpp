#include <cstdio>
#include <facebaker/facebaker_bake.hpp>
#include <memory>

#include "base/file_extension.h"
#include "base/length_units.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/progress_bar.h"
#include "commands/rig_options.h"
#include "commands/view_line.h"
#include "figures/verdict.h"
#include "report/face_report.h"
#include "report/table.h"

namespace fb::tool {
namespace {

struct EvalCommand {
  std::string archive, split;
  std::vector<std::string> sources;
  FigureOutputs outputs;
  Parallel parallel;
  RigOptions rigs;

  void run();
};

std::string eval_text(const FaceFigures& figures) {
  const ShownUnit unit = shown_unit(figures.units);
  Table table({"clip", "kind", "split", "frames", "max, " + unit.name, "p99fm, " + unit.name, "mfm, " + unit.name,
               "max", "p99fm", "mfm", "mse", "rms", "mean", "p99"});
  const double length = unit.per_unit * figures.diagonal;
  const auto add = [&](const std::string& name, const std::string& kind, const std::string& split, const Errors& e) {
    std::vector<std::string> row = {name, kind, split, std::to_string(e.frames)};
    for (const double figure : {e.max, e.p99fm, e.mfm}) row.push_back(format("%.3g", length * figure));
    for (const double figure : {e.max, e.p99fm, e.mfm, e.mse, e.rms, e.mean, e.p99})
      row.push_back(format("%.2e", figure));
    table.add(std::move(row));
  };
  const MethodReport& face = figures.methods.at(0);
  for (const ClipErrors& clip : face.independent.clips) add(clip.name, clip.kind, clip.split, clip.errors);
  add("total", "", "", face.independent.total);
  const std::string contact = face.independent.quality ? contact_text(face.independent.quality->contact) + "\n" : "";
  return verdict_text(face.independent) + "\n\n" + table.text() +
         format(
             "max, p99fm and mfm are of the worst vertices of frames: the largest, the 99th percentile and the mean. "
             "Errors without a unit are fractions of the rest mesh's diagonal, %g %s.\n",
             figures.diagonal, figures.units.c_str()) +
         format("A pose reads %.0f bytes of the model on average, 95 of 100 at most %llu.\n",
                face.independent.bytes_read.mean, static_cast<unsigned long long>(face.independent.bytes_read.p95)) +
         contact + (face.independent.expectation ? expectation_text(*face.independent.expectation) + "\n" : "");
}

// Whether a live source has clips, and none of split test.
bool has_other_clips_alone(const facebaker::Source& source) {
  fb_source_info info;
  fb_source_info_init(&info);
  facebaker::check(fb_source_describe(source.get(), &info));
  for (std::uint32_t c = 0; c < info.clip_count; ++c) {
    fb_clip clip;
    fb_clip_init(&clip);
    facebaker::check(fb_source_clip_at(source.get(), c, &clip));
    if (clip.split == FB_SPLIT_TEST) return false;
  }
  return (info.flags & FB_SOURCE_LIVE) != 0 && info.clip_count > 0;
}

std::int32_t split_from(const std::string& name) {
  return name == "all"          ? FB_SPLIT_ALL
         : name == "train"      ? FB_SPLIT_TRAIN
         : name == "validation" ? FB_SPLIT_VALIDATION
                                : FB_SPLIT_TEST;
}

void EvalCommand::run() {
  if (file_extension(archive) != ".fbk" && file_extension(sources.front()) == ".fbk")
    fail(Status::invalid_argument, "the archive comes first, then its rig: eval %s %s", shown(sources.front()).c_str(),
         shown(archive).c_str());
  const facebaker::Archive face(archive);
  std::vector<std::string> notes;
  const bool chosen = !split.empty();
  const facebaker::Source source = rigs.open(sources, notes, 0, chosen ? 0 : drawn_test_poses);
  if (!chosen) split = "test";
  if (!chosen && has_other_clips_alone(source)) {
    split = "all";
    notes.emplace_back(
        "the rig has no clips of split test: measured on all its clips, from which the face may have been learnt");
  }
  outputs.claim();
  fb_eval_desc desc;
  fb_eval_desc_init(&desc);
  desc.archive = face.get();
  desc.source = source.get();
  desc.split = split_from(split);
  desc.threads = static_cast<std::uint32_t>(parallel.threads);
  if (!outputs.report.empty() || !outputs.json.empty()) desc.measure = FB_MEASURE_QUALITY | FB_MEASURE_LOCALITY;
  const facebaker::Report report = [&] {
    ProgressBar progress;
    for (const std::string& note : notes) progress.note(note);
    desc.callbacks = progress.callbacks();
    return facebaker::eval(desc);
  }();
  const FaceFigures figures = read_figures(report);
  if (!outputs.report.empty()) {
    const std::string measured = split == "all" ? "Measured on all clips." : measured_on(figures);
    ProgressBar progress;
    write_face_report(outputs.report,
                      {figures.methods.at(0).name, measured, figures, source, {view_line(archive, sources)}}, parallel,
                      progress);
  }
  outputs.write("eval", report.json(), eval_text(figures));
}

}  // namespace

void add_eval(Command tool) {
  auto command = std::make_shared<EvalCommand>();
  const Command app = tool.add_command("eval", "Measure an archive against the true rig");
  add_archive(app, command->archive);
  add_sources(app, command->sources);
  app.add_option(
         "--split", command->split,
         "Which clips to measure on; by default those of split test, of a rig that has none all its clips, and of "
         "one without clips poses that are drawn for it")
      .one_of({"train", "validation", "test", "all"});
  command->outputs.add_to(app);
  command->rigs.add_clip_budget_to(app);
  command->rigs.add_to(app);
  add_threads(app, command->parallel);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
