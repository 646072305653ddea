#include "view/page_folder.h"

#include <array>
#include <string_view>
#include <utility>

#include "base/file.h"
#include "base/file_extension.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {
namespace {

constexpr std::uint64_t most_page_bytes = std::uint64_t{256} << 20;

constexpr std::array<std::pair<std::string_view, const char*>, 11> media_types = {{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".wasm", "application/wasm"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".webp", "image/webp"},
    {".webmanifest", "application/manifest+json"},
    {".txt", "text/plain; charset=utf-8"},
}};

std::string type_of(const std::filesystem::path& path) {
  const std::string extension = file_extension(path);
  for (const auto& [ending, type] : media_types)
    if (extension == ending) return type;
  return "application/octet-stream";
}

bool has_page(const std::filesystem::path& folder) {
  std::error_code missing;
  return std::filesystem::is_regular_file(folder / "index.html", missing);
}

}  // namespace

std::filesystem::path find_page_folder(const std::string& given) {
  constexpr const char* how = "build the viewer with samples/viewer/build.sh FOLDER";
  if (!given.empty()) {
    if (!has_page(given)) fail(Status::not_found, "--page %s: there is no index.html; %s", shown(given).c_str(), how);
    return given;
  }
  std::error_code unknown;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path();
  const std::array<std::filesystem::path, 2> places = {(program / "../share/facebaker/viewer").lexically_normal(),
                                                       (program / "../../viewer").lexically_normal()};
  for (const std::filesystem::path& place : places)
    if (has_page(place)) return place;
  fail(Status::not_found, "there is no built viewer in %s or %s; %s and give the folder by --page",
       shown(places[0]).c_str(), shown(places[1]).c_str(), how);
}

std::map<std::string, PageFile> read_page_folder(const std::filesystem::path& folder) {
  std::map<std::string, PageFile> files;
  std::uint64_t left = most_page_bytes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_symlink() || !entry.is_regular_file()) continue;
    const std::vector<std::byte> bytes = read_file(entry.path(), left);
    left -= bytes.size();
    files[entry.path().lexically_relative(folder).generic_string()] = {
        type_of(entry.path()), std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())};
  }
  return files;
}

}  // namespace fb::tool
