#include "commands/command_options.h"

#include <facebaker/facebaker_bake.h>

#include <cstdio>

#include "base/file.h"
#include "base/file_extension.h"
#include "base/shown_path.h"
#include "commands/results.h"
#include "report/face_report.h"

namespace fb::tool {

std::string whole_number(const std::string& word) {
  const bool digits = !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
  if (!digits) return word + " is no whole number";
  return word.size() < 20 ? "" : word + " is too large";
}

void add_threads(Command command, Parallel& parallel) {
  command.add_option("--threads", parallel.threads, "Threads to use; 0: all. Results do not depend on it.")
      .between(0, 1024)
      .type_name("N")
      .shows_default();
}

namespace {

// Check of the name of an archive to write.
std::string archive_name(const std::string& name) {
  return file_extension(name) == ".fbk" ? "" : shown(name) + ": the name of an archive ends in .fbk";
}

constexpr std::uint64_t most_poses = std::uint64_t{1} << 32;

}  // namespace

Option add_pose_count(Command command, std::uint64_t& poses, const char* what) {
  return command.add_option("--poses", poses, what).between(std::uint64_t{1}, most_poses).type_name("N");
}

void add_poses(Command command, std::uint64_t& poses, std::uint64_t& rig_budget, const char* usual) {
  add_pose_count(command, poses, format("Training poses to sample from the rig; by default %s", usual).c_str());
  command
      .add_option(
          "--rig-budget", rig_budget,
          "Different poses to ask of the rig at most in order to learn, at least the ends of all ranges; its "
          "own clips, tests and poses evaluated again do not count. --poses is reduced to that, and is all of it "
          "if not given")
      .between(std::uint64_t{1}, most_poses)
      .type_name("N");
}

void add_poses_like(Command command, std::vector<std::string>& files) {
  command
      .add_option("--poses-like", files,
                  "Control curves of the character, near which a third of the poses is sampled that are not of single "
                  "controls: a NumPy file of frames x controls, a .csv with named columns such as a take of Live Link "
                  "Face, or a dataset folder, but for its test clips (repeatable)")
      .type_name("FILE")
      .repeatable();
}

void add_sources(Command command, std::vector<std::string>& sources) {
  command
      .add_option("SOURCE", sources,
                  "Dataset folders of one character, a rig plugin (librig_NAME.so), a .glb, .gltf or .vrm, "
                  "exec:COMMAND for a program that speaks the rig protocol, or \"sample\" for the built-in face")
      .required();
}

Option add_archive(Command command, std::string& archive) {
  return command.add_option("FACE", archive, "The archive (.fbk)").required();
}

void add_out_archive(Command command, std::string& out) {
  command.add_option("--out", out, "The archive to write (.fbk); it appears complete or not at all")
      .type_name("FACE.fbk")
      .checked(archive_name)
      .required();
}

void add_licence(Command command, std::string& file) {
  command.add_option("--licence", file, "A text file: the licence of the face, which goes into the archive")
      .type_name("FILE");
}

void add_about(Command command, std::string& file) {
  command
      .add_option("--about", file,
                  "A JSON file that says whose the character is and what may be done with it: author, rights and more "
                  "(docs/characters.md); its fields come before those that are there already")
      .type_name("FILE.json");
}

std::string file_text(const std::string& file) {
  if (file.empty()) return {};
  const auto bytes = read_file(file, 1u << 20);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void add_json_flag(Command command, bool& json) {
  command.add_flag("--json", json, "Print the figures as JSON instead of text");
}

void add_report(Command command, std::string& folder, const char* more) {
  command
      .add_option("--report", folder,
                  std::string("Folder to write the figures into, as JSON and as a Markdown table") + more)
      .type_name("DIR");
}

std::vector<const char*> c_strings(const std::vector<std::string>& texts) {
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  return pointers;
}

std::vector<std::string> recipe_names() {
  std::vector<std::string> names;
  for (std::uint32_t r = 0; r < fb_recipe_count(); ++r) names.emplace_back(fb_recipe_name(r));
  return names;
}

void FigureOutputs::add_json_to(Command command) {
  command.add_option("--json", json, "Write the figures as JSON; - for standard output, in place of the table")
      .type_name("FILE");
}

void FigureOutputs::add_to(Command command) {
  add_json_to(command);
  add_report(command, report, ", and a page of pictures, curves and tables (index.html)");
}

void FigureOutputs::claim() {
  if (!json.empty() && json != "-") {
    json_lock_ = OutputLock::of_file(json);
    const AtomicFile trial(json);
  }
  if (!report.empty()) report_lock_ = claim_report_folder(report);
}

void FigureOutputs::write(const std::string& name, const std::string& figures, const std::string& table) const {
  if (!json.empty() && json != "-") write_file(json, figures);
  if (!report.empty()) write_report(report, name, figures, table);
  print_result(json == "-" ? figures.c_str() : table.c_str());
}

void write_report(const std::filesystem::path& folder, const std::string& name, const std::string& figures,
                  const std::string& table) {
  write_file(folder / (name + ".json"), figures);
  write_file(folder / (name + ".md"), table);
}

}  // namespace fb::tool
