#include <algorithm>
#include <cstdio>
#include <facebaker/facebaker_bake.hpp>
#include <memory>

#include "base/length_units.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/library_options.h"
#include "commands/progress_bar.h"
#include "commands/rig_options.h"
#include "commands/view_line.h"
#include "farm/shell_words.h"
#include "report/face_report.h"
#include "report/table.h"

namespace fb::tool {
namespace {

struct CompareCommand {
  CompareCommand() { fb_compare_desc_init(&desc); }

  std::vector<std::string> sources, methods = {"linear", "paper-tuned", "hero"};
  std::string work;
  FigureOutputs outputs;
  fb_compare_desc desc;
  LibraryOptions options;
  Parallel parallel;
  RigOptions rigs;

  void run();

 private:
  facebaker::Report compare(const facebaker::Source& source, const fb_callbacks& callbacks);
  std::vector<std::string> view_lines() const;
};

// A table with a column for every method and use; each row is computed from the methods' figures.
class MethodTable {
 public:
  MethodTable(const FaceFigures& figures, const char* head) : figures_(figures), table_(heads(figures, head)) {}

  template <class Cell>
  void row(std::string name, const Cell& cell) {
    std::vector<std::string> row = {std::move(name)};
    for (const MethodReport& method : figures_.methods) row.push_back(cell(method));
    table_.add(std::move(row));
  }
  std::string text() const { return table_.text() + "\n"; }

 private:
  static std::vector<std::string> heads(const FaceFigures& figures, const char* head) {
    std::vector<std::string> heads = {head};
    for (const MethodReport& method : figures.methods) heads.push_back(method.name + " " + method.use);
    return heads;
  }
  const FaceFigures& figures_;
  Table table_;
};

std::string scientific(double value) {
  return format("%.2e", value);
}

// The paper's Table 1 with more figures.
std::string errors_text(const FaceFigures& figures) {
  MethodTable table(figures, "Table 1");
  const auto add_test = [&](const std::string& test, const auto& errors) {
    const auto length = [&](double error) { return length_text(error * figures.diagonal, figures.units); };
    table.row(test + " max", [&](const MethodReport& m) { return length(errors(m).max); });
    table.row(test + " mfm", [&](const MethodReport& m) { return length(errors(m).mfm); });
    table.row(test + " MSE", [&](const MethodReport& m) { return scientific(errors(m).mse); });
    table.row(test + " max err", [&](const MethodReport& m) { return scientific(errors(m).max); });
    table.row(test + " mfm / D", [&](const MethodReport& m) { return scientific(errors(m).mfm); });
    table.row(test + " p99fm / D", [&](const MethodReport& m) { return scientific(errors(m).p99fm); });
    table.row(test + " p99", [&](const MethodReport& m) { return scientific(errors(m).p99); });
  };
  add_test("independent", [](const MethodReport& m) { return m.independent.total; });
  add_test("dependency", [](const MethodReport& m) { return m.dependency; });
  return table.text();
}

std::string clips_text(const FaceFigures& figures) {
  MethodTable table(figures, "independent MSE by clip");
  const std::vector<ClipErrors>& clips = figures.methods.at(0).independent.clips;
  for (std::size_t c = 0; c < clips.size(); ++c)
    table.row(clips[c].name, [&](const MethodReport& m) { return scientific(m.independent.clips.at(c).errors.mse); });
  return table.text();
}

std::string costs_text(const FaceFigures& figures) {
  MethodTable table(figures, "cost");
  const auto add_count = [&](const char* name, std::size_t BakedFace::*count) {
    table.row(name, [&](const MethodReport& m) { return std::to_string(m.*count); });
  };
  table.row("archive, bytes", [](const MethodReport& m) { return std::to_string(m.archive.size()); });
  table.row("touched a shot pose, bytes: mean",
            [](const MethodReport& m) { return format("%.0f", m.independent.bytes_read.mean); });
  table.row("touched a shot pose, bytes: p95",
            [](const MethodReport& m) { return std::to_string(m.independent.bytes_read.p95); });
  add_count("poses trained on", &BakedFace::poses);
  table.row("bones",
            [](const MethodReport& m) { return m.stats.bones ? std::to_string(m.stats.bones) : std::string("-"); });
  add_count("coefficients", &BakedFace::coefficients);
  add_count("trained numbers", &BakedFace::parameters);
  table.row("training, seconds", [](const MethodReport& m) { return format("%.1f", m.train_seconds); });
  return table.text();
}

std::string compare_text(const FaceFigures& figures) {
  std::string failures;
  for (const MethodFailure& failure : figures.failures)
    failures += format("The %s of %s failed: %s\n", failure.use.c_str(), failure.name.c_str(), failure.reason.c_str());
  return format(
             "%s: errors over the diagonal of the rest mesh, %g %s; mfm and p99fm: mean and 99th percentile of the "
             "frames' worst vertices.\n"
             "Independent: clips nothing was trained on. Dependency: data trained on.\n\n",
             figures.name.c_str(), figures.diagonal, figures.units.c_str()) +
         errors_text(figures) + clips_text(figures) + costs_text(figures) + failures;
}

facebaker::Report CompareCommand::compare(const facebaker::Source& source, const fb_callbacks& callbacks) {
  if (std::find(methods.begin(), methods.end(), "all") != methods.end()) methods = recipe_names();
  const std::vector<const char*> names = c_strings(methods);
  desc.source = source.get();
  desc.methods = names.data();
  desc.method_count = static_cast<std::uint32_t>(names.size());
  const std::vector<std::string> given = options.given();
  const std::vector<const char*> named = c_strings(given);
  desc.options = named.data();
  desc.option_count = static_cast<std::uint32_t>(named.size());
  desc.threads = static_cast<std::uint32_t>(parallel.threads);
  desc.work = work.empty() ? nullptr : work.c_str();
  desc.callbacks = callbacks;
  return facebaker::compare(desc);
}

// The archives that were compared are not kept: the first method is baked for the viewer.
std::vector<std::string> CompareCommand::view_lines() const {
  std::vector<std::string> bake = {"bake"};
  bake.insert(bake.end(), sources.begin(), sources.end());
  bake.insert(bake.end(), {"--recipe", methods.at(0), "--out", "face.fbk"});
  return {"facebaker " + shell_words(bake), view_line("face.fbk", sources)};
}

void CompareCommand::run() {
  std::vector<std::string> notes;
  const facebaker::Source source = rigs.open(sources, notes, desc.rig_budget);
  outputs.claim();
  std::string document;
  FaceFigures figures;
  {
    ProgressBar progress;
    for (const std::string& note : notes) progress.note(note);
    const facebaker::Report report = compare(source, progress.callbacks());
    document = report.json();
    figures = read_figures(report);
    if (!outputs.report.empty()) {
      fb_source* const recording = report.recording();
      const facebaker::SourceView measured(recording ? recording : source.get());
      write_face_report(outputs.report,
                        {figures.name + ": methods compared", measured_on(figures), figures, measured, view_lines()},
                        parallel, progress);
    }
  }
  outputs.write("compare", document, compare_text(figures));
  if (!figures.failures.empty()) {
    const MethodFailure& first = figures.failures[0];
    fail(Status::internal, "%zu of %zu bakes failed; the first, the %s of \"%s\": %s", figures.failures.size(),
         figures.failures.size() + figures.methods.size(), first.use.c_str(), first.name.c_str(), first.reason.c_str());
  }
}

}  // namespace

void add_compare(Command tool) {
  std::vector<std::string> names = recipe_names();
  names.push_back("all");
  auto command = std::make_shared<CompareCommand>();
  const Command app = tool.add_command("compare", "Bake and measure several methods side by side on the same data");
  add_sources(app, command->sources);
  app.add_option("--methods", command->methods, "Methods, separated by commas; all: every one there is")
      .separated_by(',')
      .repeatable()
      .one_of(names)
      .shows_default();
  add_poses(app, command->desc.poses, command->desc.rig_budget);
  command->options.add_to(app, FB_OPTION_SAMPLING);
  command->options.add_to(app, FB_OPTION_TRAINING);
  app.add_option("--work", command->work,
                 "Folder for intermediate files, kept so that the same command can continue; by default "
                 "a temporary one")
      .type_name("DIR");
  command->outputs.add_to(app);
  command->rigs.add_clip_budget_to(app);
  command->rigs.add_to(app);
  add_threads(app, command->parallel);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
