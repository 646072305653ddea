#pragma once

#include <filesystem>
#include <string>

namespace fb {

// The path of a file in a folder, or below it, that data from anyone names. Fails with bad_data if it does not lie
// there: an absolute name, one that leads out by "..", a link to elsewhere. Whether there is such a file is not
// checked. Fails with io where the system cannot say where it lies.
std::filesystem::path path_inside(const std::filesystem::path& folder, const std::string& name);

}  // namespace fb
