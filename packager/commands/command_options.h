// Options that several commands share, declared in the same way in each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/output_lock.h"
#include "base/parallel.h"
#include "options/command.h"

namespace fb::tool {

// Check of counts: "" if the word is a non-negative whole number that fits 64 bits, else what is wrong with it.
std::string whole_number(const std::string& word);

void add_threads(Command command, Parallel& parallel);
// --poses, a number of poses that is described by `what`.
Option add_pose_count(Command command, std::uint64_t& poses, const char* what);
// --poses and --rig-budget. `usual`: how many poses there are by default.
void add_poses(Command command, std::uint64_t& poses, std::uint64_t& rig_budget, const char* usual = "20000");
// --poses-like: files of control curves.
void add_poses_like(Command command, std::vector<std::string>& files);
void add_sources(Command command, std::vector<std::string>& sources);
Option add_archive(Command command, std::string& archive);
void add_out_archive(Command command, std::string& out);
// --licence and --about: text files whose texts go into the archive.
void add_licence(Command command, std::string& file);
void add_about(Command command, std::string& file);
std::string file_text(const std::string& file);  // "" without a file
void add_json_flag(Command command, bool& json);
// `more` ends the description: what is written besides.
void add_report(Command command, std::string& folder, const char* more = "");

// The same texts for the C interface; valid as long as `texts`.
std::vector<const char*> c_strings(const std::vector<std::string>& texts);

// Names of all recipes.
std::vector<std::string> recipe_names();

// Where the figures of a measuring command go: --json FILE, --report DIR, standard output.
struct FigureOutputs {
  std::string json, report;

  void add_to(Command command);
  void add_json_to(Command command);  // for commands without a report
  // Locks both, before the work begins. Fails if either could not be written.
  void claim();
  // Writes the JSON and the report's NAME.json and NAME.md; prints the table, or with --json - the JSON.
  void write(const std::string& name, const std::string& figures, const std::string& table) const;

 private:
  std::optional<OutputLock> json_lock_, report_lock_;
};

// Writes name.json and name.md into a folder of claim_report_folder.
void write_report(const std::filesystem::path& folder, const std::string& name, const std::string& figures,
                  const std::string& table);

}  // namespace fb::tool
