#include "base/locked_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/shown_path.h"
#include "base/status.h"

namespace fb {
namespace {

enum class Lock { taken, held, unsupported };

Lock try_lock(int descriptor, int kind) {
  if (::flock(descriptor, kind | LOCK_NB) == 0) return Lock::taken;
  return errno == EWOULDBLOCK ? Lock::held : Lock::unsupported;
}

// Whether the path still names the open file: its last holder may have removed or renamed it before the lock was taken.
bool names(const std::filesystem::path& path, const struct stat& open) {
  struct stat named;
  return ::lstat(path.c_str(), &named) == 0 && named.st_dev == open.st_dev && named.st_ino == open.st_ino;
}

}  // namespace

std::optional<LockedFile> LockedFile::open(const std::filesystem::path& path, Missing missing) {
  const int flags = O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | (missing == Missing::create ? O_CREAT : 0);
  constexpr int tries = 100;  // one more for each holder that removes it just then
  for (int i = 0; i < tries; ++i) {
    const int descriptor = ::open(path.c_str(), flags, 0666);
    if (descriptor < 0 && errno == ENOENT && missing == Missing::leave) return std::nullopt;
    if (descriptor < 0) fail(Status::io, "%s: cannot be written: %s", shown(path).c_str(), std::strerror(errno));
    LockedFile file(path, descriptor, true);
    struct stat open;
    if (::fstat(descriptor, &open) != 0) file.fail_here("cannot be written");
    if (!S_ISREG(open.st_mode)) fail(Status::io, "%s: cannot be written: is not a regular file", shown(path).c_str());
    const Lock lock = try_lock(descriptor, LOCK_EX);
    if (lock == Lock::held) return std::nullopt;
    file.exclusive_ = lock == Lock::taken;
    if (names(path, open)) return file;
  }
  return std::nullopt;
}

LockedFile::Held LockedFile::held(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0 && errno == ENOENT) return Held::no;
  if (descriptor < 0) fail(Status::io, "%s: cannot be read: %s", shown(path).c_str(), std::strerror(errno));
  const LockedFile file(path, descriptor, false);
  const Lock lock = try_lock(descriptor, LOCK_SH);  // shared: two that look are not in each other's way
  if (lock == Lock::held) return Held::yes;
  return lock == Lock::unsupported && !file.empty() ? Held::perhaps : Held::no;
}

LockedFile::LockedFile(LockedFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), exclusive_(other.exclusive_) {}

LockedFile& LockedFile::operator=(LockedFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(exclusive_, other.exclusive_);
  return *this;
}

LockedFile::~LockedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool LockedFile::empty() const {
  struct stat open;
  return ::fstat(descriptor_, &open) == 0 && open.st_size == 0;
}

void LockedFile::fail_here(const char* what) const {
  fail(Status::io, "%s: %s: %s", shown(path_).c_str(), what, std::strerror(errno));
}

void LockedFile::clear() {
  if (::ftruncate(descriptor_, 0) != 0) fail_here("cannot be written");
}

void LockedFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail_here("writing failed");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void LockedFile::sync() {
  if (::fsync(descriptor_) != 0) fail_here("writing failed");
}

void LockedFile::remove() noexcept {
  struct stat open;
  if (::fstat(descriptor_, &open) == 0 && open.st_nlink > 0) ::unlink(path_.c_str());
}

void sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0 && errno == EACCES) return;  // may be written, not read
  if (descriptor < 0) fail(Status::io, "%s: cannot be opened: %s", shown(folder).c_str(), std::strerror(errno));
  const int error = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  if (error != 0 && error != EINVAL && error != ENOTSUP)
    fail(Status::io, "%s: cannot be synced to the disk: %s", shown(folder).c_str(), std::strerror(error));
}

}  // namespace fb
