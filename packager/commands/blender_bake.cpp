#include "commands/blender_bake.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "base/file_extension.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/results.h"

namespace fb::tool {
namespace {

constexpr const char* with_blender_flag = "--with-blender";

std::filesystem::path this_program() {
  std::error_code unknown;
  return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

// What the command `bake` was given besides the source and the flag that brought it here.
std::vector<std::string> other_words(const std::string& source) {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  words.erase(words.begin(), words.begin() + std::min<std::ptrdiff_t>(2, std::ssize(words)));  // facebaker bake
  std::erase(words, with_blender_flag);
  if (const auto at = std::find(words.begin(), words.end(), source); at != words.end()) words.erase(at);
  return words;
}

std::filesystem::path find_script() {
  const std::filesystem::path folder = this_program().parent_path();
  const std::array<std::filesystem::path, 2> places = {
      (folder / "../share/facebaker/blender/facebaker_blender/headless.py").lexically_normal(),
      (folder / "../../../bindings/blender/facebaker_blender/headless.py").lexically_normal()};
  for (const std::filesystem::path& place : places) {
    std::error_code missing;
    if (std::filesystem::is_regular_file(place, missing)) return place;
  }
  fail(Status::not_found, "%s: the add-on for Blender is not here: there is no %s and no %s", with_blender_flag,
       shown(places[0]).c_str(), shown(places[1]).c_str());
}

}  // namespace

void bake_with_blender(const std::string& source) {
  std::error_code missing;
  if (!std::filesystem::is_regular_file(source, missing))
    fail(Status::not_found, "%s: there is no such file", shown(source).c_str());
  const std::filesystem::path script = find_script();
  const bool scene = file_extension(source) == ".blend";
  std::vector<std::string> words = {"blender", "-b"};
  if (scene) words.push_back(source);
  words.insert(words.end(), {"--python-exit-code", "1", "-P", script.string(), "--", "bake"});
  if (!scene) words.insert(words.end(), {"--import", source});
  const std::vector<std::string> others = other_words(source);
  words.insert(words.end(), others.begin(), others.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::setenv("FACEBAKER_TOOL", this_program().c_str(), 0);
  ::setenv("FACEBAKER_PYTHON", script.parent_path().parent_path().c_str(), 0);  // where it is installed, else skipped
  if (results_descriptor() >= 0) ::dup2(results_descriptor(), STDOUT_FILENO);  // it prints the results now
  ::execvp("blender", arguments.data());
  const int error = errno;
  if (error == ENOENT) fail(Status::not_found, "%s: there is no program blender in PATH", with_blender_flag);
  fail(Status::io, "blender: cannot be run: %s", std::strerror(error));
}

}  // namespace fb::tool
