#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "farm/farm_folder.h"

namespace fb::tool {

struct FarmRun {
  std::string program;                           // facebaker
  std::size_t jobs = 1;                          // characters at once
  std::vector<std::string> more;                 // options for each of them
  std::function<bool()> stop;                    // asked several times a second
  std::function<void(const std::string&)> tell;  // a line of progress
};

// Bakes characters, each in a process of its own, whose output is its log. One that another process is baking at that
// moment is left to it. What fails is told, and the others go on. Asked to stop, it has those at work stop too; where
// this process is killed, they are. Fails with io where a log cannot be written or no process started.
void run_farm(const FarmFolder& folder, const std::vector<FarmCharacter>& characters, const FarmRun& run);

}  // namespace fb::tool
