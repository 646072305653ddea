#include <algorithm>
#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/results.h"
#include "report/table.h"

namespace fb::tool {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t rows_shown = 10;

struct DiffCommand {
  std::string before, now;
  double tolerance = 0;
  bool json = false;

  void run() const;
};

std::string text_of(const Json& value) {
  if (value.is_null()) return "-";
  return value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string change_text(const Json& change) {
  return text_of(change.at("before")) + " -> " + text_of(change.at("now"));
}

std::string declaration_text(const Json& declared) {
  const auto one = [](const Json& control) {
    return format("%g..%g, at rest %g, group \"%s\"", control.at("min").get<double>(), control.at("max").get<double>(),
                  control.at("default").get<double>(), control.at("group").get<std::string>().c_str());
  };
  return one(declared.at("before")) + " -> " + one(declared.at("now"));
}

// Controls and mesh that differ, a line each.
std::string declared_text(const Json& document) {
  std::string text;
  for (const Json& sentence : document.at("schema")) text += sentence.get<std::string>() + "\n";
  for (const Json& name : document.at("controls_added")) text += "control added: " + name.get<std::string>() + "\n";
  for (const Json& name : document.at("controls_removed")) text += "control removed: " + name.get<std::string>() + "\n";
  for (const Json& control : document.at("controls"))
    if (const Json& declared = control.at("declared"); declared.is_object())
      text += "control " + control.at("name").get<std::string>() + ": " + declaration_text(declared) + "\n";
  const Json& vertices = document.at("vertices");
  if (vertices.at("before") != vertices.at("now"))
    text += "vertices: " + change_text(vertices) + "; poses of different meshes are not compared\n";
  if (!document.at("same_polygons").get<bool>()) text += "the polygons differ\n";
  if (!document.at("same_texture_coordinates").get<bool>()) text += "the texture coordinates differ\n";
  if (!document.at("same_exact_poses").get<bool>())
    text += "the poses that are kept exact, or their corrections, differ\n";
  return text;
}

// Entries of what is said about the character, of provenance and certificate that differ, without lists.
std::string texts_text(const Json& document) {
  std::string text;
  for (const char* list : {"about", "provenance", "certificate"})
    for (const auto& [key, change] : document.at(list).items())
      if (!change.at("before").is_array() && !change.at("now").is_array())
        text += std::string(list) + " " + key + ": " + change_text(change) + "\n";
  if (!document.at("same_licence").get<bool>()) text += "the licences differ\n";
  return text;
}

// How far vertices lie apart, and where. `units`: of distances.
std::string motion_text(const Json& document) {
  if (!document.at("rest").is_object()) return "";
  const std::string units = document.at("units");
  Table table({"what", "mse", "max", "max, " + units, "at vertex", "where"});
  const auto add = [&](const std::string& what, const Json& figures) {
    table.add({what, format("%.2e", figures.at("mse").get<double>()), format("%.2e", figures.at("max").get<double>()),
               format("%.3g", figures.at("distance").get<double>()),
               figures.at("max") > 0 ? text_of(figures.at("vertex")) : "", figures.at("place").get<std::string>()});
  };
  add("rest mesh", document.at("rest"));
  std::size_t moved = 0;
  for (const Json& control : document.at("controls"))
    if (control.at("max") > 0 && moved++ < rows_shown)
      add(format("%s at %g", control.at("name").get<std::string>().c_str(), control.at("value").get<double>()),
          control);
  add(text_of(document.at("random").at("frames")) + " random poses", document.at("random"));
  std::string text = table.text();
  if (moved > rows_shown) text += format("and %zu more controls that alone move otherwise\n", moved - rows_shown);
  std::size_t regions = 0;
  for (const Json& region : document.at("regions"))
    if (regions++ < rows_shown)
      text += format("region %s: up to %.2e in random poses\n", region.at("title").get<std::string>().c_str(),
                     region.at("max").get<double>());
  return text +
         format("mse and max are over the diagonal, %g %s.\n", document.at("diagonal").get<double>(), units.c_str());
}

// Whether controls and mesh agree, and no vertex lies further apart than `tolerance` of the diagonal.
bool agree(const Json& document, double tolerance) {
  const auto near = [&](const Json& figures) { return figures.is_object() && figures.at("max") <= tolerance; };
  return document.at("schema").empty() && document.at("controls_added").empty() &&
         document.at("controls_removed").empty() && document.at("same_polygons").get<bool>() &&
         document.at("same_texture_coordinates").get<bool>() && near(document.at("rest")) &&
         near(document.at("random")) && std::ranges::all_of(document.at("controls"), [&](const Json& control) {
           return near(control) && control.at("declared").is_null();
         });
}

void DiffCommand::run() const {
  const facebaker::Archive old_face(before), face(now);
  const std::string text = facebaker::diff(old_face, face).json();
  const Json document = Json::parse(text);
  const bool same = agree(document, tolerance);
  if (json)
    print_result(text);
  else
    print_result(before + " -> " + now + "\n" + declared_text(document) + motion_text(document) + texts_text(document) +
                 (same ? "The faces are the same.\n" : ""));
  if (!same) fail(Status::bad_data, "the faces differ");
}

}  // namespace

void add_diff(Command tool) {
  auto command = std::make_shared<DiffCommand>();
  const Command app = tool.add_command("diff", "Say what has changed between two archives, where and by how much");
  app.add_option("old", command->before, "Archive (.fbk)").type_name("OLD.fbk").required();
  app.add_option("new", command->now, "Archive of the same character, made later").type_name("NEW.fbk").required();
  app.add_option("--tolerance", command->tolerance, "Distance over the diagonal up to which vertices are the same")
      .not_negative()
      .type_name("E")
      .shows_default();
  add_json_flag(app, command->json);
  app.footer("Exit code 0 if controls, meshes, driven joints and poses are the same, 1 if they differ.");
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
