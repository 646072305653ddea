#include <algorithm>
#include <array>
#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "base/file.h"
#include "base/length_units.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/face_rights.h"
#include "commands/results.h"
#include "report/table.h"

namespace fb::tool {
namespace {

using Json = nlohmann::ordered_json;

struct InspectCommand {
  std::string archive, thumbnail, on;
  bool json = false, controls = false;

  void run() const;

 private:
  void write_thumbnail(const fb_archive_info& info) const;
};

// The features and layers of a network: "12 > 32 relu > 32 relu skip > 8 wide".
std::string layers_text(const Json& region) {
  std::string text = std::to_string(region.at("inputs").get<std::uint64_t>());
  for (const Json& layer : region.at("layers")) {
    const std::string activation = layer.at("activation");
    text += " > " + std::to_string(layer.at("outputs").get<std::uint64_t>());
    if (activation != "linear") text += " " + activation;
    if (layer.at("skip").get<bool>()) text += " skip";
    if (layer.at("bits") == 16) text += " wide";
  }
  return text;
}

// With columns for those labels that any control has.
std::string control_table(const Json& document) {
  std::vector<std::string> heads = {"control", "min", "max", "default", "group"};
  for (const char* label : {"arkit", "facs", "unit", "mirror"})
    for (const Json& control : document.at("control_list"))
      if (control.contains(label)) {
        heads.push_back(label);
        break;
      }
  Table table(heads);
  for (const Json& control : document.at("control_list")) {
    std::vector<std::string> row = {control.at("name")};
    for (const char* number : {"min", "max", "default"}) row.push_back(format("%g", control.at(number).get<double>()));
    for (std::size_t i = 4; i < heads.size(); ++i) row.push_back(control.value(heads[i], ""));
    table.add(std::move(row));
  }
  return table.text();
}

std::string count_text(const Json& number) {
  return std::to_string(number.get<std::uint64_t>());
}

// A mesh's materials, each once, by name or, where they have none, by number.
std::string materials_text(const Json& mesh, const Json& document) {
  std::vector<std::string> names;
  std::string text;
  for (const Json& run : mesh.at("materials")) {
    if (!run.contains("material")) continue;
    const Json& index = run.at("material");
    std::string name = document.at("materials").at(index.get<std::size_t>()).at("name");
    if (name.empty()) name = count_text(index);
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    text += (text.empty() ? "" : ", ") + name;
    names.push_back(std::move(name));
  }
  return text;
}

std::string textures_text(const Json& material) {
  std::string text;
  for (const Json& texture : material.at("textures"))
    text += (text.empty() ? "" : ", ") + texture.at("slot").get<std::string>() + " " + count_text(texture.at("image"));
  return text;
}

// How many vertices follow joints; "" without such a skin.
std::string skin_text(const Json& document, const char* key, const char* joints) {
  if (!document.contains(key)) return "";
  return format("skin: %s vertices follow %s, at most %s each\n", count_text(document[key].at("vertices")).c_str(),
                joints, count_text(document[key].at("influences")).c_str());
}

std::string numbers_text(const Json& numbers) {
  std::string text;
  for (const Json& number : numbers) text += (text.empty() ? "" : ", ") + number.get<std::string>();
  return text;
}

std::string outer_rotations_text(const Json& joint) {
  std::string text;
  for (const Json& rotation : joint.value("outer_rotations", Json::array()))
    text += (text.empty() ? "" : "; ") + numbers_text(rotation);
  return text;
}

// Tables of what a character has: those that are not empty.
std::string character_tables(const Json& document) {
  Table meshes({"mesh", "vertices", "polygons", "materials"});
  Table materials({"material", "name", "alpha", "textures: images"});
  Table images({"image", "name", "media type", "bytes"});
  Table sockets({"socket", "vertices"});
  Table exact({"exact pose"});
  Table joints({"joint", "parent"});
  Table driven({"driven joint", "parent", "numbers", "outer rotations"});
  Table levels({"level of detail", "vertices", "polygons", "coefficients"});
  const auto each = [&](const char* key, Table& table, const auto& row) {
    if (!document.contains(key)) return std::string();
    for (std::size_t i = 0; i < document[key].size(); ++i) table.add(row(document[key][i], std::to_string(i)));
    return table.text();
  };
  using Row = std::vector<std::string>;
  const auto mesh = [&](const Json& json, const std::string&) {
    return Row{json.at("name"), count_text(json.at("vertices")), count_text(json.at("polygons")),
               materials_text(json, document)};
  };
  const auto material = [](const Json& json, const std::string& index) {
    return Row{index, json.at("name"), json.at("alpha_mode"), textures_text(json)};
  };
  const auto image = [](const Json& json, const std::string& index) {
    return Row{index, json.at("name"), json.at("media_type"), count_text(json.at("bytes"))};
  };
  const auto socket = [](const Json& json, const std::string&) {
    return Row{json.at("name"), std::to_string(json.at("vertices").size())};
  };
  const auto level = [](const Json& json, const std::string&) {
    return Row{count_text(json.at("level")), count_text(json.at("vertices")), count_text(json.at("polygons")),
               count_text(json.at("coefficients"))};
  };
  const auto exact_pose = [](const Json& json, const std::string&) { return Row{json.at("name")}; };
  const auto joint = [&](const Json& json, const std::string&) {
    if (!json.contains("parent")) return Row{json.at("name"), ""};
    return Row{json.at("name"), document["joints"][json["parent"].get<std::size_t>()].at("name")};
  };
  const auto driven_joint = [](const Json& json, const std::string&) {
    return Row{json.at("name"), json.value("parent", ""), numbers_text(json.at("numbers")), outer_rotations_text(json)};
  };
  return each("meshes", meshes, mesh) + each("materials", materials, material) + each("images", images, image) +
         each("sockets", sockets, socket) + each("joints", joints, joint) + skin_text(document, "skin", "joints") +
         each("driven_joints", driven, driven_joint) + skin_text(document, "driven_skin", "driven joints") +
         each("exact_poses", exact, exact_pose) + each("levels", levels, level);
}

// Errors over the diagonal as certificates tell them; those of the frames' worst vertices first, and in a unit, too.
struct ErrorTable {
  static constexpr std::array<const char*, 3> worst = {"max", "p99fm", "mfm"};
  static constexpr std::array<const char*, 4> others = {"mse", "rms", "mean", "p99"};

  ErrorTable(const std::string& units, double diagonal)
      : unit(shown_unit(units)), length(unit.per_unit * diagonal), table(heads(unit.name)) {}
  static std::vector<std::string> heads(const std::string& unit) {
    std::vector<std::string> heads = {"errors over the diagonal", "frames"};
    for (const char* key : worst) heads.push_back(std::string(key) + ", " + unit);
    heads.insert(heads.end(), worst.begin(), worst.end());
    heads.insert(heads.end(), others.begin(), others.end());
    return heads;
  }

  ShownUnit unit;
  double length;  // of the diagonal, in that unit
  Table table;
};

// A row of the table from a JSON object; nothing if it is none. An archive may hold any JSON.
void add_errors(ErrorTable& errors, const std::string& what, const Json& json) {
  if (!json.is_object()) return;
  std::vector<std::string> row = {what};
  const auto frames = json.contains("poses") ? json.find("poses") : json.find("frames");
  row.push_back(frames != json.end() && frames->is_number_unsigned() ? std::to_string(frames->get<std::uint64_t>())
                                                                     : "");
  const auto add = [&](const char* key, double factor) {
    const auto figure = json.find(key);
    row.push_back(figure != json.end() && figure->is_number() ? format("%.3g", factor * figure->get<double>()) : "");
  };
  for (const char* key : ErrorTable::worst) add(key, errors.length);
  for (const char* key : ErrorTable::worst) add(key, 1);
  for (const char* key : ErrorTable::others) add(key, 1);
  errors.table.add(std::move(row));
}

// Rows of a list of such objects, named by `key`.
void add_error_list(ErrorTable& table, const char* what, const Json& json, const char* list, const char* key) {
  const auto found = json.find(list);
  if (found == json.end() || !found->is_array()) return;
  for (const Json& item : *found)
    if (item.is_object() && item.contains(key) && item[key].is_string())
      add_errors(table, what + item[key].get<std::string>(), item);
}

std::string certificate_text(const Json& document) {
  const Json& certificate = document.at("certificate");
  if (!certificate.is_object()) return "";
  ErrorTable table(document.at("units"), document.at("diagonal"));
  add_errors(table, "trained on", certificate.value("dependency", Json()));
  const Json held_back = certificate.value("held_back", Json());
  add_errors(table, "held back", held_back);
  if (held_back.is_object()) add_error_list(table, "  kind ", held_back, "kinds", "kind");
  const Json unseen = certificate.value("independent", Json());
  add_errors(table, "unseen", unseen);
  if (unseen.is_object()) {
    add_error_list(table, "  kind ", unseen, "kinds", "kind");
    add_error_list(table, "  clip ", unseen, "clips", "name");
    add_error_list(table, "  region ", unseen, "regions", "name");
    add_errors(table, "  gaps of what touches", unseen.value("contact", Json()));
  }
  const Json levels = certificate.value("levels", Json());
  for (std::size_t k = 0; levels.is_array() && k < levels.size(); ++k)
    add_errors(table, format("level of detail %zu", k + 1), levels[k]);
  for (const char* key : {"quantisation", "exact", "repacked", "bound"})
    add_errors(table, key, certificate.value(key, Json()));
  std::string text = table.table.text();
  const Json normals = unseen.is_object() ? unseen.value("normals", Json()) : Json();
  if (normals.is_object() && normals.contains("rms_degrees") && normals["rms_degrees"].is_number())
    text += format("normals, unseen: %.3g degrees (root mean square)\n", normals["rms_degrees"].get<double>());
  return text;
}

std::string words_of(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string provenance_text(const Json& provenance) {
  std::string text;
  for (const auto& [key, value] : provenance.items()) text += key + ": " + words_of(value) + "\n";
  return text;
}

// What is said about the character, a line a field; those of an object behind its name.
std::string about_lines(const Json& about) {
  std::string text;
  const auto add = [&](const std::string& name, const Json& value) {
    std::string line = name + ": " + words_of(value);
    for (char& byte : line)
      if (static_cast<unsigned char>(byte) < 32 || byte == 127) byte = ' ';
    text += line + "\n";
  };
  for (const auto& [key, value] : about.items()) {
    if (!value.is_object()) {
      add(key, value);
      continue;
    }
    for (const auto& [inner, field] : value.items()) add(key + " " + inner, field);
  }
  return text;
}

// What binds of the rights: clauses of FaceRights, a line each.
std::string binding_lines(const Json& document) {
  std::string text;
  if (document.contains("rights"))
    for (const Json& clause : document["rights"].at("binding")) text += clause.get<std::string>() + "\n";
  return text;
}

std::string summary_table(const facebaker::Archive& archive, const Json& document) {
  const fb_archive_info info = archive.info();
  const std::string units = document.at("units");
  Table table({"what", "value"});
  table.add({"name", info.name});
  table.add({"vertices", std::to_string(info.vertex_count)});
  table.add({"polygons", count_text(document.at("polygons"))});
  table.add({"controls", std::to_string(info.control_count)});
  table.add({"diagonal", format("%g %s", document.at("diagonal").get<double>(), units.c_str())});
  table.add({"up axis", document.at("up_axis")});
  table.add({"recipe", *info.recipe ? info.recipe : "-"});
  if (document.at("learned").is_string()) table.add({"learned", document.at("learned")});
  table.add({"coefficients", std::to_string(info.coefficient_count)});
  table.add({"network parameters", std::to_string(info.parameter_count)});
  table.add({"basis numbers", std::to_string(info.value_count)});
  table.add({"format version", format("%u.%u", info.format_version / 1000, info.format_version % 1000)});
  table.add({"bytes", std::to_string(info.byte_count)});
  for (std::uint32_t s = 0; s < info.section_count; ++s) {
    const fb_section section = archive.section(s);
    std::string bytes = std::to_string(section.stored_bytes);
    if (section.unpacked_bytes != section.stored_bytes) bytes += " of " + std::to_string(section.unpacked_bytes);
    table.add({std::string("  ") + section.name, bytes});
  }
  table.add({"bytes in memory", count_text(document.at("runtime_bytes"))});
  return table.text();
}

std::string inspect_text(const std::string& path, const facebaker::Archive& archive, const Json& document) {
  const fb_archive_info info = archive.info();
  std::string text =
      path + "\n" + binding_lines(document) + summary_table(archive, document) + character_tables(document);
  if (document.contains("about")) text += about_lines(document["about"]);
  for (const Json& region : document.at("network").at("regions"))
    text += "network \"" + region.at("name").get<std::string>() + "\": " + layers_text(region) + "\n";
  text += certificate_text(document) + provenance_text(document.at("provenance"));
  if (info.proof_poses > 0) text += format("proof: %u poses (facebaker verify)\n", info.proof_poses);
  if (*info.licence) text += std::string("licence:\n") + info.licence + "\n";
  for (std::uint32_t n = 0; n < info.note_count; ++n)
    text += std::string("note: ") + fb_archive_note_at(archive.get(), n) + "\n";
  return text;
}

void InspectCommand::write_thumbnail(const fb_archive_info& info) const {
  if (!info.thumbnail)
    fail(Status::not_found, "%s has no thumbnail; pack --thumbnail draws one", shown(archive).c_str());
  write_file(thumbnail, std::span(static_cast<const std::byte*>(info.thumbnail), info.thumbnail_bytes));
}

void InspectCommand::run() const {
  const facebaker::Archive face(archive);
  if (!thumbnail.empty()) {
    write_thumbnail(face.info());
    print_result(thumbnail + "\n");
    return;
  }
  const std::string text = facebaker::inspect(face).json();
  Json document = Json::parse(text);
  if (!on.empty() && document.contains("rights")) document["rights"] = FaceRights(face.info().about, on).document();
  if (json) {
    print_result(on.empty() ? text : document.dump(2) + "\n");
    return;
  }
  print_result(inspect_text(archive, face, document).c_str());
  if (controls) print_result(control_table(document).c_str());
}

}  // namespace

void add_inspect(Command tool) {
  auto command = std::make_shared<InspectCommand>();
  const Command app = tool.add_command("inspect", "Show what is in an archive");
  add_archive(app, command->archive);
  app.add_flag("--controls", command->controls, "List the controls too (--json always does)");
  const Option json = app.add_flag("--json", command->json, "Print everything as JSON");
  add_on(app, command->on);
  app.add_option("--thumbnail", command->thumbnail, "Write the picture of the face, a PNG, and nothing else")
      .type_name("FILE.png")
      .not_with(json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
