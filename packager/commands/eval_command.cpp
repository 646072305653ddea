#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/measure/evaluate.h"
#include "bake/rig/rig_evaluator.h"
#include "base/file.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/figure_outputs.h"
#include "commands/progress_bar.h"
#include "commands/report_json.h"
#include "commands/table.h"
#include "report/face_report.h"

namespace fb::tool {
using namespace archive;
using namespace bake;
namespace {

struct EvalCommand {
  std::string archive, split = "test";
  std::vector<std::string> sources;
  FigureOutputs outputs;
  Parallel parallel;

  void run();

 private:
  void write_page(MethodReport face, std::vector<std::byte> bytes, Source& source) const;
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

void EvalCommand::write_page(MethodReport face, std::vector<std::byte> bytes, Source& source) const {
  face.name = std::filesystem::path(archive).stem().string();
  face.bytes = bytes.size();
  face.archive = std::move(bytes);
  const CompareReport faces = alone(std::move(face), source);
  const std::string measured =
      split == "all" ? "Measured on all clips." : "Measured on the clips of the split " + split + ".";
  ProgressBar progress;
  write_face_report(outputs.report, {faces.methods[0].name, measured, faces, source}, parallel, progress);
}

void EvalCommand::run() {
  const std::vector<std::byte> bytes = read_file(archive);
  with_context(archive, [&] { return read_archive(bytes).format_version; });
  const auto source = open_sources(sources);
  outputs.check();
  std::optional<Split> only;
  if (split != "all") only = split_from(split);
  const bool detailed = !outputs.report.empty() || !outputs.json.empty();
  MethodReport face;
  {
    ProgressBar progress;
    for (const std::string& note : source->notes()) progress.note(note);
    face.independent =
        evaluate_archive(bytes, *source, only, parallel, progress, detailed ? Detail::quality : Detail::errors);
    if (detailed && source->live()) {
      const std::array<std::span<const std::byte>, 1> archives = {bytes};
      RigEvaluator evaluator(*source, parallel);
      face.locality = measure_locality(archives, evaluator, {}, progress).at(0);
    }
  }
  const std::string json = eval_json(archive, face.independent, face.locality), text = eval_text(face.independent);
  if (!outputs.report.empty()) write_page(std::move(face), bytes, *source);
  outputs.write("eval", json, text);
}

}  // namespace

void add_eval(CLI::App& tool) {
  auto command = std::make_shared<EvalCommand>();
  CLI::App* app = tool.add_subcommand("eval", "Measure an archive against the true rig");
  add_archive(*app, command->archive);
  add_sources(*app, command->sources);
  app->add_option("--split", command->split, "Which clips to measure on")
      ->check(CLI::IsMember({"train", "validation", "test", "all"}))
      ->capture_default_str();
  command->outputs.add_to(*app, ", and a page of pictures, curves and tables (index.html)");
  add_threads(*app, command->parallel);
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
