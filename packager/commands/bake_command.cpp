#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

#include "bake/dataset/open_source.h"
#include "bake/pipeline/bake.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/rig/rig_evaluator.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/figure_outputs.h"
#include "commands/progress_bar.h"
#include "commands/report_json.h"
#include "commands/table.h"
#include "report/face_report.h"

namespace fb::tool {
using namespace bake;
namespace {

struct BakeCommand {
  std::vector<std::string> sources;
  std::string out, use = "backlot", work, report, licence;
  BakeOptions options;
  bool json = false;

  void run();

 private:
  void write_page(const Baked& baked, Source& source, Progress& progress) const;
};

std::string bake_text(const Baked& baked) {
  Table table({"figure", "value"});
  table.add({"bytes", std::to_string(baked.archive.size())});
  table.add({"poses trained on", std::to_string(baked.poses)});
  table.add({"rig calls", std::to_string(baked.rig_calls)});
  table.add({"coefficients", std::to_string(baked.coefficients)});
  table.add({"trained numbers", std::to_string(baked.parameters)});
  table.add({"training, seconds", format("%.1f", baked.train_seconds)});
  table.add({"rounding, mse", format("%.2e", baked.quantisation.mse)});
  table.add({"rounding, worst / diagonal", format("%.2e", baked.quantisation.max)});
  return table.text();
}

// Measures the archive on clips it was not trained on, if the source has any, and writes the page.
void BakeCommand::write_page(const Baked& baked, Source& source, Progress& progress) const {
  MethodReport face;
  face.name = options.recipe;
  face.use = options.use;
  face.bytes = baked.archive.size();
  face.archive = baked.archive;
  face.stats = baked.stats;
  face.parameters = baked.parameters;
  face.coefficients = baked.coefficients;
  face.poses = baked.poses;
  face.train_seconds = baked.train_seconds;
  std::string measured = "Not measured: there is no clip of the splits test and validation.";
  for (const Split split : {Split::test, Split::validation}) {
    const auto& clips = source.clips();
    if (std::none_of(clips.begin(), clips.end(), [&](const Clip& clip) { return clip.split == split; })) continue;
    measured = format("Measured on the clips of the split %s.", name_of(split));
    face.independent = evaluate_archive(baked.archive, source, split, options.parallel, progress, Detail::quality);
    break;
  }
  const std::uint64_t left =
      options.rig_budget > 0 ? options.rig_budget - std::min(options.rig_budget, baked.rig_calls) : UINT64_MAX;
  if (const auto locality = locality_within(left, source.schema().control_count()); locality && source.live()) {
    const std::array<std::span<const std::byte>, 1> archives = {baked.archive};
    RigEvaluator evaluator(source, options.parallel);
    face.locality = measure_locality(archives, evaluator, *locality, progress).at(0);
  }
  const CompareReport faces = alone(std::move(face), source);
  write_face_report(report, {source.schema().name + ": " + options.recipe, measured, faces, source}, options.parallel,
                    progress);
}

void BakeCommand::run() {
  options.use = use_from(use);
  options.work = work;
  options.licence = licence_text(licence);
  const auto source = open_sources(sources);
  if (!report.empty()) claim_report_folder(report);  // better to learn now that it cannot be
  Baked baked;
  {
    ProgressBar progress;
    for (const std::string& note : source->notes()) progress.note(note);
    baked = bake_to_file(*source, out, options, progress);
    if (!report.empty()) write_page(baked, *source, progress);
  }
  if (!report.empty()) write_report(report, "bake", bake_json(out, baked), bake_text(baked));
  std::fputs(json ? bake_json(out, baked).c_str() : (out + "\n" + bake_text(baked)).c_str(), stdout);
}

}  // namespace

void add_bake(CLI::App& tool) {
  auto command = std::make_shared<BakeCommand>();
  CLI::App* app = tool.add_subcommand("bake", "Learn a face from poses and write it as an archive");
  add_sources(*app, command->sources);
  app->add_option("--out", command->out, "The archive to write (.fbk); it appears complete or not at all")
      ->type_name("FACE.fbk")
      ->required();
  app->add_option("--recipe", command->options.recipe, "How to learn")
      ->check(CLI::IsMember(recipe_names()))
      ->capture_default_str();
  app->add_option("--use", command->use, "variant: shots are not trained on; backlot: they are")
      ->check(CLI::IsMember({"variant", "backlot"}))
      ->capture_default_str();
  add_poses(*app, command->options.poses, command->options.rig_budget);
  add_mix(*app, command->options.mix);
  app->add_option("--epochs", command->options.epochs, "Passes over the training poses; 0: the recipe's own number")
      ->check(whole_number)
      ->type_name("N")
      ->capture_default_str();
  app->add_option("--max-bytes", command->options.max_bytes,
                  "Bytes the archive may have: as precise as they allow; 0: as precise as the recipe says")
      ->check(whole_number)
      ->type_name("N")
      ->capture_default_str();
  app->add_option("--max-error", command->options.max_error,
                  "Largest error allowed on validation poses, over the diagonal: in as few bytes as it allows; 0: any")
      ->check(CLI::NonNegativeNumber)
      ->type_name("E")
      ->capture_default_str();
  add_force(*app, command->options.force);
  add_licence(*app, command->licence);
  app->add_option("--created", command->options.created, "A date to put into the archive; without it there is none")
      ->type_name("DATE");
  app->add_option("--work", command->work,
                  "Folder that keeps what makes resuming possible; by default <out>.work, which is "
                  "removed once the archive is whole")
      ->type_name("DIR");
  add_report(*app, command->report, ", and a page of pictures, curves and tables (index.html)");
  add_learning_curve(*app, command->options.learning_curve);
  add_seed(*app, command->options.seed);
  add_threads(*app, command->options.parallel);
  add_json_flag(*app, command->json);
  app->footer(
      "--poses and --mix are for rigs; a dataset is used as it is. Ctrl-C keeps what is done: the same command "
      "goes on from there.");
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
