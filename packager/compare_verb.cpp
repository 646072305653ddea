#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "bake/recipes/compare.h"
#include "base/file.h"
#include "progress_bar.h"
#include "report_folder.h"
#include "report_json.h"
#include "table.h"
#include "verb_options.h"
#include "verbs.h"

namespace fb {
namespace {

struct CompareVerb {
  std::vector<std::string> sources, methods = {"linear", "paper"};
  std::string json, report, work;
  BakeOptions options;

  void run();
};

// One row a method and use, in the arrangement of the paper's Table 1.
std::string compare_text(const CompareReport& report) {
  Table table(
      {"method", "use", "independent mse", "max", "mfm", "dependency mse", "max", "mfm", "bytes", "training s"});
  for (const MethodReport& method : report.methods) {
    std::vector<std::string> row = {method.name, name_of(method.use)};
    for (const Errors* errors : {&method.independent.total, &method.dependency})
      for (const double figure : {errors->mse, errors->max, errors->mfm}) row.push_back(format("%.2e", figure));
    row.push_back(std::to_string(method.bytes));
    row.push_back(format("%.1f", method.train_seconds));
    table.add(std::move(row));
  }
  return format("%s: errors over the diagonal, %g %s. Independent: unseen clips; dependency: data trained on.\n\n",
                report.name.c_str(), report.diagonal, report.units.c_str()) +
         table.text();
}

// A folder of this process for intermediate files, removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "facebaker-XXXXXX").string();
    if (!mkdtemp(pattern.data())) fail(Status::io, "%s: cannot be made", pattern.c_str());
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void CompareVerb::run() {
  if (!json.empty() && json != "-") const AtomicFile probe(json);  // better to learn now that it cannot be written
  const auto source = open_sources(sources);
  std::optional<TemporaryFolder> temporary;
  options.work = work.empty() ? temporary.emplace().path() : std::filesystem::path(work);
  CompareReport result;
  {
    ProgressBar progress;
    result = compare(*source, methods, options, progress);
  }
  const std::string figures = compare_json(result), table = compare_text(result);
  if (!json.empty() && json != "-") write_file(json, figures);
  if (!report.empty()) write_report(report, "compare", figures, table);
  std::fputs(json == "-" ? figures.c_str() : table.c_str(), stdout);
}

}  // namespace

void add_compare(CLI::App& tool) {
  auto verb = std::make_shared<CompareVerb>();
  CLI::App* app = tool.add_subcommand("compare", "Bake and measure several methods side by side on the same data");
  add_sources(*app, verb->sources);
  app->add_option("--methods", verb->methods, "Methods, separated by commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(recipe_names()))
      ->capture_default_str();
  add_poses(*app, verb->options.poses);
  add_mix(*app, verb->options.mix);
  app->add_option("--epochs", verb->options.epochs, "Passes over the training poses; 0: each recipe's own number")
      ->type_name("N")
      ->capture_default_str();
  app->add_option("--work", verb->work,
                  "Folder for intermediate files, kept so that the same command can go on; by default "
                  "a temporary one")
      ->type_name("DIR");
  app->add_option("--json", verb->json, "Write the figures as JSON; - for standard output, in place of the table")
      ->type_name("FILE");
  add_report(*app, verb->report);
  add_seed(*app, verb->options.seed);
  add_threads(*app, verb->options.parallel);
  app->callback([verb] { verb->run(); });
}

}  // namespace fb
