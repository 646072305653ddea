// What a glTF file names by URIs: data within them, and files in its own folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fb::bake {

// The bytes of a URI such as "data:image/png;base64,AAAA"; nothing if it is no such URI. Fails with bad_data on what is
// no base64 (RFC 4648, section 4).
std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri);

// A URI without its percent-encoding: "skin%201.png" is "skin 1.png".
std::string decode_percent(std::string_view uri);

// The files in the folder of a glTF file, or below it.
class FilesBeside {
 public:
  // Without a folder there are none.
  explicit FilesBeside(std::optional<std::filesystem::path> folder) : folder_(std::move(folder)) {}

  // `uri`: relative, as the file has it. Where no file has its name without percent-encoding, one that has it as it
  // stands is read: "example 10%.bin". Fails with bad_data on another kind of address, on what lies elsewhere, and
  // where there is no folder; with not_found; and with limit beyond 2 GiB in all.
  std::vector<std::byte> read(const std::string& uri);

 private:
  std::filesystem::path path_of(const std::string& name) const;

  std::optional<std::filesystem::path> folder_;
  std::uint64_t left_ = std::uint64_t{1} << 31;  // bytes
};

}  // namespace fb::bake
