#include "bake/bag/partial_folder.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "base/file.h"
#include "base/replaced_file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

// Without a slash at the end, which would put what stands beside it inside.
fs::path named(const fs::path& folder) {
  return resolve_links(folder.has_filename() ? folder : folder.parent_path());
}

fs::path parent_of(const fs::path& folder) {
  return folder.has_parent_path() ? folder.parent_path() : ".";
}

OutputLock locked(const fs::path& folder) {
  if (folder.filename().empty() || folder.filename() == "." || folder.filename() == "..")
    fail(Status::invalid_argument, "%s: give the folder a name", shown(folder).c_str());
  std::error_code error;
  const fs::file_status found = fs::status(folder, error);
  if (fs::exists(found) && !fs::is_directory(found))
    fail(Status::io, "%s: is there, and is no folder", shown(folder).c_str());
  if (fs::is_directory(found) && !fs::is_empty(folder, error) && !error)
    fail(Status::io, "%s: is not empty: a bag is written into a new folder", shown(folder).c_str());
  make_folder(parent_of(folder));
  return OutputLock::of_file(folder);
}

}  // namespace

PartialFolder::PartialFolder(const fs::path& folder)
    : folder_(named(folder)), partial_(folder_), lock_(locked(folder_)) {
  partial_ += ".facebaker-partial";
  remove_folder(partial_);
  make_folder(partial_);
}

PartialFolder::~PartialFolder() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(partial_, ignored);
}

void PartialFolder::commit() {
  if (std::rename(partial_.c_str(), folder_.c_str()) != 0)
    fail(Status::io, "%s: cannot be renamed into place: %s", shown(folder_).c_str(), std::strerror(errno));
  committed_ = true;
  sync_folder(parent_of(folder_));
}

}  // namespace fb::bake
