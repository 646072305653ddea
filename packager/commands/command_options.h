// Options that several commands share, declared the same way in each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/parallel.h"

namespace CLI {
class App;
}

namespace fb::tool {

// For options that count: the text of what is wrong with a word, empty if it is a whole number that is not negative
// and fits 64 bits.
std::string whole_number(const std::string& word);

void add_threads(CLI::App& command, Parallel& parallel);
void add_seed(CLI::App& command, std::uint64_t& seed);
// --poses and --rig-budget; a budget alone asks for as many poses as it allows.
void add_poses(CLI::App& command, std::uint64_t& poses, std::uint64_t& rig_budget);
void add_mix(CLI::App& command, std::string& mix);
void add_sources(CLI::App& command, std::vector<std::string>& sources);
void add_archive(CLI::App& command, std::string& archive);
// --force: writes the nearest there is where --max-bytes or --max-error cannot be met.
void add_force(CLI::App& command, bool& force);
// --licence: a text file that goes into the archive.
void add_licence(CLI::App& command, std::string& file);
std::string licence_text(const std::string& file);  // "" of no file
void add_learning_curve(CLI::App& command, bool& learning_curve);
void add_json_flag(CLI::App& command, bool& json);
// `also` continues the sentence of the help: what is written besides.
void add_report(CLI::App& command, std::string& folder, const char* also = "");

}  // namespace fb::tool
