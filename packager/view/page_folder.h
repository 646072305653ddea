// The built viewer: a folder of static files with an index.html.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace fb::tool {

// The folder that was given, or where none was, the first with an index.html of: ../share/facebaker/viewer beside the
// running program, where it is installed, and ../../viewer, in a build tree. Fails with not_found, saying how to build
// the viewer.
std::filesystem::path find_page_folder(const std::string& given);

struct PageFile {
  std::string type;  // media type
  std::string bytes;
};

// All regular files of a folder and those below it, links left out, by their path in it with "/" between names. Fails
// with limit beyond 256 MiB in all.
std::map<std::string, PageFile> read_page_folder(const std::filesystem::path& folder);

}  // namespace fb::tool
