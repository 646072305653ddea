#pragma once

#include <filesystem>
#include <string>

namespace fb {

// Writes folder/name.json and folder/name.md, making the folder if it is missing.
void write_report(const std::filesystem::path& folder, const std::string& name, const std::string& json,
                  const std::string& table);

}  // namespace fb
