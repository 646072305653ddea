#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <optional>

#include "base/shown_path.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/progress_bar.h"
#include "commands/results.h"
#include "report/dataset_report.h"

namespace fb::tool {
namespace {

struct CheckCommand {
  std::string folder;
  FigureOutputs outputs;
  Parallel parallel;

  void run();
};

void CheckCommand::run() {
  outputs.claim();
  fb_check_desc desc;
  fb_check_desc_init(&desc);
  desc.directory = folder.c_str();
  desc.threads = static_cast<std::uint32_t>(parallel.threads);
  const facebaker::Report report = [&] {
    ProgressBar progress;
    desc.callbacks = progress.callbacks();
    return facebaker::check_dataset(desc);
  }();
  const DatasetFigures figures = read_dataset_figures(report);
  if (!outputs.report.empty()) {
    std::optional<facebaker::Source> source;
    if (figures.bakeable) source.emplace(std::vector<std::string>{folder});
    ProgressBar progress;
    write_dataset_report(outputs.report, figures, source ? std::optional(facebaker::SourceView(*source)) : std::nullopt,
                         parallel, progress);
  }
  outputs.write("check", report.json(), dataset_text(figures));
  finish_results();
  if (!figures.bakeable)
    fail(Status::bad_data, "%s: cannot be baked: %zu fault%s", shown(folder).c_str(), figures.faults.size(),
         figures.faults.size() == 1 ? "" : "s");
}

}  // namespace

void add_check(Command tool) {
  auto command = std::make_shared<CheckCommand>();
  const Command app = tool.add_command(
      "check",
      "Find everything that is wrong with a dataset folder, and what its poses cover; fails if it cannot be baked");
  app.add_option("DIR", command->folder, "The dataset folder").required();
  command->outputs.add_to(app);
  add_threads(app, command->parallel);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
