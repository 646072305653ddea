#include "farm/farm_folder.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <system_error>

#include "base/decimal_points.h"
#include "base/locked_file.h"
#include "base/status.h"
#include "farm/shell_words.h"

namespace fb::tool {
namespace {

constexpr std::streamoff tail_bytes = 1 << 16;
constexpr std::string_view failure_start = "facebaker bake: ";
constexpr std::string_view interrupted_start = "facebaker bake: interrupted";

std::string command_start(const FarmCharacter& character) {
  return "facebaker bake " + shell_words(character.words) + " --out ";
}

// The last lines of a text, the last first, without those that are empty.
std::vector<std::string> last_lines(std::ifstream& file) {
  file.seekg(0, std::ios::end);
  const std::streamoff size = file.tellg(), first = std::max<std::streamoff>(0, size - tail_bytes);
  file.seekg(first);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) lines.push_back(std::move(line));
  std::ranges::reverse(lines);
  return lines;
}

}  // namespace

const char* name_of(FarmState state) {
  constexpr std::array<const char*, 5> names = {"waiting", "running", "stopped", "failed", "done"};
  return names.at(static_cast<std::size_t>(state));
}

std::vector<std::string> FarmFolder::arguments(const FarmCharacter& character,
                                               const std::vector<std::string>& more) const {
  std::vector<std::string> words = {"bake"};
  words.insert(words.end(), character.words.begin(), character.words.end());
  words.insert(words.end(), {"--out", archive(character).string()});
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string FarmFolder::command_line(const FarmCharacter& character, const std::vector<std::string>& more) const {
  return "facebaker " + shell_words(arguments(character, more));
}

std::string FarmFolder::end_line(int code, double seconds) {
  return format("exit code %d after %.1f s", code, seconds);
}

FarmStatus FarmFolder::status(const FarmCharacter& character) const {
  const std::filesystem::path path = log(character);
  std::filesystem::path lock = path;
  if (LockedFile::held(lock += ".facebaker-lock") == LockedFile::Held::yes) return {FarmState::running, "", 0};
  std::ifstream file(path, std::ios::binary);
  std::string first;
  if (!file || !std::getline(file, first) || !first.starts_with(command_start(character))) return {};
  const std::vector<std::string> lines = last_lines(file);
  FarmStatus status = {FarmState::stopped, "", 0};
  int code = -1;
  const DecimalPoints decimal_points;
  if (lines.empty() || std::sscanf(lines[0].c_str(), "exit code %d after %lf s", &code, &status.seconds) != 2)
    return status;
  std::error_code unknown;
  if (code == 0 && std::filesystem::is_regular_file(archive(character), unknown)) {
    status.state = FarmState::done;
    return status;
  }
  const auto told =
      std::ranges::find_if(lines, [](const std::string& line) { return line.starts_with(failure_start); });
  if (told != lines.end() && told->starts_with(interrupted_start)) return status;
  status.state = code == 0 ? FarmState::waiting : FarmState::failed;  // waiting: somebody has removed the archive
  if (status.state == FarmState::failed)
    status.message = told != lines.end() ? told->substr(failure_start.size()) : lines[0];
  return status;
}

}  // namespace fb::tool
