#pragma once

#include <filesystem>
#include <string>

namespace fb {

// SHA-256 (FIPS 180-4) of a file's bytes, as 64 hexadecimal digits in lower case. Fails as InputFile does.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace fb
