#include "base/replaced_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "base/open_descriptor.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb {
namespace {

constexpr mode_t rights = 0777, group_rights = 0070;

[[noreturn]] void fail_to_write(const std::filesystem::path& path, int error) {
  fail(Status::io, "%s: cannot be written: %s", shown(path).c_str(), std::strerror(error));
}

}  // namespace

std::filesystem::path resolve_links(const std::filesystem::path& path) {
  std::filesystem::path resolved = path;
  std::error_code error;
  for (int links = 0; std::filesystem::is_symlink(std::filesystem::symlink_status(resolved, error)); ++links) {
    constexpr int most_links = 40;  // as Linux follows
    if (links == most_links) fail_to_write(path, ELOOP);
    const std::filesystem::path target = std::filesystem::read_symlink(resolved, error);
    if (error) fail_to_write(resolved, error.value());
    resolved = resolved.parent_path() / target;
  }
  return resolved;
}

ReplacedFile::ReplacedFile(const std::filesystem::path& path) {
  struct stat found;
  if (::stat(path.c_str(), &found) != 0) return;  // creating says why, if it is not merely missing
  if (S_ISDIR(found.st_mode)) fail(Status::io, "%s: is a directory, not a file", shown(path).c_str());
  // Renaming would replace a device by a file.
  if (!S_ISREG(found.st_mode)) fail(Status::io, "%s: cannot be written: is not a regular file", shown(path).c_str());
  if (::access(path.c_str(), W_OK) != 0) fail_to_write(path, errno);
  exists_ = true;
  mode_ = found.st_mode & rights;
  owner_ = found.st_uid;
  group_ = found.st_gid;
}

bool ReplacedFile::create(const std::filesystem::path& path) const {
  const mode_t mode = exists_ ? S_IRUSR | S_IWUSR : mode_;
  const OpenDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
  if (file.get() < 0 && errno == EEXIST) return false;
  if (file.get() < 0) fail_to_write(path, errno);
  if (!exists_) return true;
  struct stat created;
  if (::fstat(file.get(), &created) != 0) fail_to_write(path, errno);
  const auto no_owner = static_cast<uid_t>(-1);
  const auto no_group = static_cast<gid_t>(-1);
  const bool same_group = created.st_gid == group_ || ::fchown(file.get(), no_owner, group_) == 0;
  [[maybe_unused]] const bool same_owner = created.st_uid == owner_ || ::fchown(file.get(), owner_, no_group) == 0;
  // Another group has no more rights than all others.
  const mode_t kept = same_group ? mode_ : mode_ & (~group_rights | (mode_ << 3));
  if (::fchmod(file.get(), kept) != 0 && errno != EPERM && errno != ENOTSUP) fail_to_write(path, errno);
  return true;
}

}  // namespace fb
