#pragma once

#include <string>
#include <vector>

#include "farm/farm_folder.h"

namespace fb::tool {

// A table of what is done, running or failed, and how good what is done is: by the certificates of the archives. One
// that cannot be read is a failure.
std::string farm_table(const FarmFolder& folder, const std::vector<FarmCharacter>& characters);

// How many are done.
std::size_t done_count(const FarmFolder& folder, const std::vector<FarmCharacter>& characters);

}  // namespace fb::tool
