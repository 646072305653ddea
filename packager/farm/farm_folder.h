// What a farm has on the disk, which is all that it knows: of each character NAME.fbk, its log NAME.log, and, until the
// archive is complete, NAME.fbk.work.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "farm/character_list.h"

namespace fb::tool {

enum class FarmState {
  waiting,  // never begun, or begun with other options than the list now has
  running,  // some process, here or elsewhere, has the lock of the log
  stopped,  // interrupted or killed: goes on from its work folder
  failed,   // told why
  done      // has an archive of these options
};
const char* name_of(FarmState state);

struct FarmStatus {
  FarmState state = FarmState::waiting;
  std::string message;  // of a failure: its first line
  double seconds = 0;   // that the last run took; 0: not known
};

class FarmFolder {
 public:
  explicit FarmFolder(std::filesystem::path path) : path_(std::move(path)) {}

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path archive(const FarmCharacter& character) const { return path_ / (character.name + ".fbk"); }
  std::filesystem::path log(const FarmCharacter& character) const { return path_ / (character.name + ".log"); }
  // Its last lines are looked at, whoever wrote it.
  FarmStatus status(const FarmCharacter& character) const;

  // The first line of a log: the command. `more`: options that are no part of the list.
  std::string command_line(const FarmCharacter& character, const std::vector<std::string>& more) const;
  // The arguments of that command.
  std::vector<std::string> arguments(const FarmCharacter& character, const std::vector<std::string>& more) const;
  // The last line of a log: how the command ended. `code`: of exit, or 128 + signal.
  static std::string end_line(int code, double seconds);

 private:
  std::filesystem::path path_;
};

}  // namespace fb::tool
