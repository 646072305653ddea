#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "archive/reader.h"
#include "base/file.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/inspect_json.h"
#include "commands/table.h"
#include "runtime/evaluator.h"

namespace fb::tool {
using namespace archive;
using namespace runtime;
namespace {

struct InspectCommand {
  std::string archive;
  bool json = false, controls = false;

  void run() const;
};

std::string widths(const PackedRegion& region) {
  std::string text = std::to_string(region.features.size());
  for (const PackedLayer& layer : region.layers)
    text += format(" > %u%s%s%s", layer.outputs,
                   layer.activation == Activation::linear ? "" : (" " + name_of(layer.activation)).c_str(),
                   layer.skip ? " skip" : "", layer.wide ? " wide" : "");
  return text;
}

std::string control_table(const RigSchema& schema) {
  Table table({"control", "min", "max", "default", "group"});
  for (const Control& control : schema.controls)
    table.add({control.name, format("%g", control.minimum), format("%g", control.maximum), format("%g", control.rest),
               control.group});
  return table.text();
}

std::string inspect_text(const std::string& path, const Archive& archive, std::uint64_t total_bytes,
                         std::uint64_t runtime_bytes) {
  const PackedModel& model = archive.model;
  const std::string recipe = recipe_of(archive);
  Table table({"what", "value"});
  const auto add = [&](const char* what, std::string value) { table.add({what, std::move(value)}); };
  add("name", model.schema.name);
  add("vertices", std::to_string(model.rest.vertex_count()));
  add("polygons", std::to_string(model.rest.polygon_sizes.size()));
  add("controls", std::to_string(model.schema.control_count()));
  add("diagonal", format("%g %s", model.rest.diagonal(), model.schema.units.c_str()));
  add("up axis", model.schema.up_axis);
  add("recipe", recipe.empty() ? "-" : recipe);
  add("coefficients", std::to_string(model.columns));
  add("network parameters", std::to_string(model.parameter_count()));
  add("basis numbers", std::to_string(model.value_count()));
  add("format version", format("%u.%u", archive.format_version / 1000, archive.format_version % 1000));
  add("bytes", std::to_string(total_bytes));
  for (const SectionInfo& section : archive.sections)
    table.add({"  " + section.name, section.raw_bytes == section.stored_bytes
                                        ? std::to_string(section.stored_bytes)
                                        : format("%llu of %llu", static_cast<unsigned long long>(section.stored_bytes),
                                                 static_cast<unsigned long long>(section.raw_bytes))});
  add("bytes in memory", std::to_string(runtime_bytes));
  std::string text = path + "\n" + table.text();
  for (const PackedRegion& region : model.regions)
    text += format("network \"%s\": %s\n", region.name.c_str(), widths(region).c_str());
  text += certificate_text(archive) + provenance_text(archive);
  if (!archive.proof.hashes.empty())
    text += format("proof: %zu poses (facebaker verify)\n", archive.proof.hashes.size());
  if (!archive.text.licence.empty()) text += "licence:\n" + archive.text.licence + "\n";
  for (const std::string& note : archive.notes) text += "note: " + note + "\n";
  return text;
}

void InspectCommand::run() const {
  const auto bytes = read_file(archive);
  const Archive contents = with_context(archive, [&] { return read_archive(bytes); });
  const std::uint64_t runtime_bytes = Evaluator(contents.model).bytes();
  if (json) {
    std::fputs(inspect_json(archive, contents, bytes.size(), runtime_bytes).c_str(), stdout);
    return;
  }
  std::fputs(inspect_text(archive, contents, bytes.size(), runtime_bytes).c_str(), stdout);
  if (controls) std::fputs(control_table(contents.model.schema).c_str(), stdout);
}

}  // namespace

void add_inspect(CLI::App& tool) {
  auto command = std::make_shared<InspectCommand>();
  CLI::App* app = tool.add_subcommand("inspect", "Show what is in an archive");
  add_archive(*app, command->archive);
  app->add_flag("--controls", command->controls, "List the controls too (--json always does)");
  app->add_flag("--json", command->json, "Print everything as JSON");
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
