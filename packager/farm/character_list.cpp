#include "farm/character_list.h"

#include <map>
#include <sstream>

#include "base/file.h"
#include "base/file_extension.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "farm/shell_words.h"

namespace fb::tool {
namespace {

constexpr std::string_view plugin_prefix = "librig_";
constexpr std::uint64_t longest_list = std::uint64_t{16} << 20;  // bytes

bool is_name(std::string_view text) {
  if (text.empty() || text[0] == '.' || text[0] == '-') return false;
  for (const char c : text)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
          c == '-'))
      return false;
  return true;
}

// Without what follows a # at the beginning of a word that is not in quotes.
std::string without_comment(const std::string& line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '\\' && quote != '\'')
      ++i;
    else if (quote != 0)
      quote = c == quote ? '\0' : quote;
    else if (c == '"' || c == '\'')
      quote = c;
    else if (c == '#' && (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t'))
      return line.substr(0, i);
  }
  return line;
}

// The name of a source's files where none is given: "aura" of path/librig_aura.so.
std::string name_of_source(const std::string& source) {
  if (source.starts_with("exec:")) fail(Status::bad_data, "a command needs a name: NAME=exec:...");
  std::filesystem::path path(source);
  if (!path.has_filename()) path = path.parent_path();
  std::string name = path.stem().string();
  if (file_extension(path) == ".so" && name.starts_with(plugin_prefix)) name = name.substr(plugin_prefix.size());
  if (!is_name(name))
    fail(Status::bad_data,
         "\"%s\" cannot be a name of files: write NAME=SOURCE, of letters, digits, \".\", \"_\", \"-\"",
         shown(name).c_str());
  return name;
}

FarmCharacter character_of(std::vector<std::string> words) {
  FarmCharacter character;
  if (words[0].starts_with("-"))
    fail(Status::bad_data, "begins with the option %s, not with a source", shown(words[0]).c_str());
  const std::size_t end = words[0].find('=');
  if (end != std::string::npos && is_name(words[0].substr(0, end))) {
    character.name = words[0].substr(0, end);
    words[0] = words[0].substr(end + 1);
    if (words[0].empty()) fail(Status::bad_data, "no source after \"%s=\"", character.name.c_str());
  } else {
    character.name = name_of_source(words[0]);
  }
  for (const std::string& word : words)
    if (word == "--out" || word.starts_with("--out="))
      fail(Status::bad_data, "--out: archives are written to the folder of the farm, as NAME.fbk");
  character.words = std::move(words);
  return character;
}

}  // namespace

std::vector<FarmCharacter> read_character_list(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, longest_list);
  std::istringstream text(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  text.exceptions(std::ios::badbit);  // memory that runs out is no end of the list
  std::vector<FarmCharacter> characters;
  std::map<std::string, std::size_t> lines;
  std::size_t number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (line.ends_with('\r')) line.pop_back();
    with_context(format("%s, line %zu", shown(path).c_str(), number), [&] {
      std::vector<std::string> words = words_of_line(without_comment(line));
      if (words.empty()) return;
      FarmCharacter character = character_of(std::move(words));
      character.line = number;
      const auto [same, fresh] = lines.try_emplace(character.name, number);
      if (!fresh)
        fail(Status::bad_data, "\"%s\" is the name of line %zu too: write NAME=SOURCE", character.name.c_str(),
             same->second);
      characters.push_back(std::move(character));
    });
  }
  if (characters.empty()) fail(Status::bad_data, "%s: no characters", shown(path).c_str());
  return characters;
}

}  // namespace fb::tool
