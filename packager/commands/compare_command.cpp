#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "bake/dataset/open_source.h"
#include "bake/pipeline/compare.h"
#include "bake/pipeline/recipe_table.h"
#include "base/file.h"
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

struct CompareCommand {
  std::vector<std::string> sources, methods = {"linear", "paper-tuned", "hero"};
  std::string work;
  FigureOutputs outputs;
  BakeOptions options;

  void run();
};

// A table with a column for every method and use; each row is named and filled from the method's report.
class MethodTable {
 public:
  MethodTable(const CompareReport& report, const char* head) : report_(report), table_(heads(report, head)) {}

  template <class Cell>
  void row(std::string name, const Cell& cell) {
    std::vector<std::string> row = {std::move(name)};
    for (const MethodReport& method : report_.methods) row.push_back(cell(method));
    table_.add(std::move(row));
  }
  std::string text() const { return table_.text() + "\n"; }

 private:
  static std::vector<std::string> heads(const CompareReport& report, const char* head) {
    std::vector<std::string> heads = {head};
    for (const MethodReport& method : report.methods) heads.push_back(method.name + " " + name_of(method.use));
    return heads;
  }
  const CompareReport& report_;
  Table table_;
};

// The paper's Table 1 with more figures, then the unseen clips one by one, then what each method costs.
std::string compare_text(const CompareReport& report) {
  const auto figure = [](double value) { return format("%.2e", value); };
  MethodTable errors(report, "Table 1");
  const auto add_test = [&](const std::string& test, const Errors& (*of)(const MethodReport&)) {
    errors.row(test + " MSE", [&](const MethodReport& m) { return figure(of(m).mse); });
    errors.row(test + " max err", [&](const MethodReport& m) { return figure(of(m).max); });
    errors.row(test + " p99", [&](const MethodReport& m) { return figure(of(m).p99); });
    errors.row(test + " mfm", [&](const MethodReport& m) { return figure(of(m).mfm); });
  };
  add_test("independent", [](const MethodReport& m) -> const Errors& { return m.independent.total; });
  add_test("dependency", [](const MethodReport& m) -> const Errors& { return m.dependency; });
  MethodTable clips(report, "independent MSE by clip");
  for (std::size_t c = 0; c < report.methods.at(0).independent.clips.size(); ++c)
    clips.row(report.methods[0].independent.clips[c].name,
              [&](const MethodReport& m) { return figure(m.independent.clips[c].errors.mse); });
  MethodTable costs(report, "cost");
  costs.row("archive, bytes", [](const MethodReport& m) { return std::to_string(m.bytes); });
  costs.row("touched a shot pose, bytes: mean",
            [](const MethodReport& m) { return format("%.0f", m.independent.touched.mean); });
  costs.row("touched a shot pose, bytes: p95",
            [](const MethodReport& m) { return std::to_string(m.independent.touched.p95); });
  costs.row("poses trained on", [](const MethodReport& m) { return std::to_string(m.poses); });
  costs.row("bones",
            [](const MethodReport& m) { return m.stats.bones ? std::to_string(m.stats.bones) : std::string("-"); });
  costs.row("coefficients", [](const MethodReport& m) { return std::to_string(m.coefficients); });
  costs.row("trained numbers", [](const MethodReport& m) { return std::to_string(m.parameters); });
  costs.row("training, seconds", [](const MethodReport& m) { return format("%.1f", m.train_seconds); });
  std::string failures;
  for (const MethodFailure& failure : report.failures)
    failures += format("The %s of %s failed: %s\n", name_of(failure.use), failure.name.c_str(), failure.reason.c_str());
  return format(
             "%s: errors over the diagonal of the rest mesh, %g %s; mfm: mean over frames of the worst vertex.\n"
             "Independent: clips nothing was trained on. Dependency: data trained on.\n\n",
             report.name.c_str(), report.diagonal, report.units.c_str()) +
         errors.text() + clips.text() + costs.text() + failures;
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

void CompareCommand::run() {
  if (std::find(methods.begin(), methods.end(), "all") != methods.end()) methods = recipe_names();
  const auto source = open_sources(sources);
  outputs.check();
  std::optional<TemporaryFolder> temporary;
  options.work = work.empty() ? temporary.emplace().path() : std::filesystem::path(work);
  CompareReport result;
  {
    ProgressBar progress;
    for (const std::string& note : source->notes()) progress.note(note);
    result = compare(*source, methods, options, progress);
    if (!outputs.report.empty())
      write_face_report(outputs.report,
                        {result.name + ": methods compared", "Measured on the clips of the split test.", result,
                         result.recorded ? *result.recorded : *source},
                        options.parallel, progress);
  }
  outputs.write("compare", compare_json(result), compare_text(result));
  if (!result.failures.empty())
    fail(Status::internal, "%zu of %zu bakes failed; the first, the %s of \"%s\": %s", result.failures.size(),
         result.failures.size() + result.methods.size(), name_of(result.failures[0].use),
         result.failures[0].name.c_str(), result.failures[0].reason.c_str());
}

}  // namespace

void add_compare(CLI::App& tool) {
  std::vector<std::string> names = recipe_names();
  names.push_back("all");
  auto command = std::make_shared<CompareCommand>();
  CLI::App* app = tool.add_subcommand("compare", "Bake and measure several methods side by side on the same data");
  add_sources(*app, command->sources);
  app->add_option("--methods", command->methods, "Methods, separated by commas; all: every one there is")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  add_poses(*app, command->options.poses, command->options.rig_budget);
  add_mix(*app, command->options.mix);
  app->add_option("--epochs", command->options.epochs, "Passes over the training poses; 0: each recipe's own number")
      ->check(whole_number)
      ->type_name("N")
      ->capture_default_str();
  app->add_option("--work", command->work,
                  "Folder for intermediate files, kept so that the same command can go on; by default "
                  "a temporary one")
      ->type_name("DIR");
  command->outputs.add_to(*app, ", and a page of pictures, curves and tables (index.html)");
  add_learning_curve(*app, command->options.learning_curve);
  add_seed(*app, command->options.seed);
  add_threads(*app, command->options.parallel);
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
