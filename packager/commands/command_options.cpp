#include "commands/command_options.h"

#include <CLI/CLI.hpp>

#include "base/file.h"

namespace fb::tool {

std::string whole_number(const std::string& word) {
  const bool digits = !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
  if (!digits) return word + " is no whole number";
  return word.size() < 20 ? "" : word + " is too large";
}

void add_threads(CLI::App& command, Parallel& parallel) {
  command.add_option("--threads", parallel.threads, "Threads to use; 0: all there are. Results do not depend on it.")
      ->check(CLI::Range(0, 1024))
      ->type_name("N")
      ->capture_default_str();
}

void add_seed(CLI::App& command, std::uint64_t& seed) {
  command.add_option("--seed", seed, "Seed of everything random: the same seed gives the same bytes")
      ->check(whole_number)
      ->type_name("N")
      ->capture_default_str();
}

void add_poses(CLI::App& command, std::uint64_t& poses, std::uint64_t& rig_budget) {
  const CLI::Range count(std::uint64_t{1}, std::uint64_t{1} << 32);
  const CLI::Option* given = command.add_option("--poses", poses, "Poses to ask the rig for")
                                 ->check(count)
                                 ->type_name("N")
                                 ->capture_default_str();
  command
      .add_option("--rig-budget", rig_budget,
                  "Poses to ask the rig for at most, for whatever reason: probing, its own clips, tests; new poses are "
                  "cut to what that leaves, and are as many as that without --poses")
      ->check(count)
      ->type_name("N");
  command.parse_complete_callback([given, &poses, &rig_budget] {
    if (rig_budget > 0 && given->empty()) poses = rig_budget;
  });
}

void add_mix(CLI::App& command, std::string& mix) {
  command
      .add_option(
          "--mix", mix,
          "How poses are spread over the kinds: paper (excitations, regions, calisthenics) or dense (mostly many "
          "controls of many regions at once)")
      ->check(CLI::IsMember({"paper", "dense"}))
      ->capture_default_str();
}

void add_sources(CLI::App& command, std::vector<std::string>& sources) {
  command
      .add_option(
          "SOURCE", sources,
          "Dataset folders of one character, a rig plugin (librig_NAME.so), a .glb or .gltf with morph targets, or "
          "\"sample\" for the built-in face")
      ->required();
}

void add_archive(CLI::App& command, std::string& archive) {
  command.add_option("FACE", archive, "The archive (.fbk)")->required();
}

void add_force(CLI::App& command, bool& force) {
  command.add_flag("--force", force,
                   "Write the nearest there is where --max-bytes or --max-error cannot be met, instead of failing");
}

void add_licence(CLI::App& command, std::string& file) {
  command.add_option("--licence", file, "A text file: the licence of the face, which goes into the archive")
      ->type_name("FILE");
}

std::string licence_text(const std::string& file) {
  if (file.empty()) return {};
  const auto bytes = read_file(file, 1u << 20);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void add_learning_curve(CLI::App& command, bool& learning_curve) {
  command.add_flag("--learning-curve", learning_curve,
                   "Bake also on 1/8, 1/4 and 1/2 of the poses, for the report, and measure on clips not trained on");
}

void add_json_flag(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print the figures as JSON instead of text");
}

void add_report(CLI::App& command, std::string& folder, const char* also) {
  command
      .add_option("--report", folder,
                  std::string("Folder to write the figures into, as JSON and as a readable table") + also)
      ->type_name("DIR");
}

}  // namespace fb::tool
