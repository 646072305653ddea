#include "base/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/shown_path.h"

namespace fb {

InputFile::InputFile(std::filesystem::path path, std::uint64_t limit) : path_(std::move(path)) {
  // Opening a pipe waits for a writer unless told not to; regular files do not care.
  handle_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (handle_ < 0) {
    if (errno == ENOENT || errno == ENOTDIR) fail_on(path_, Status::not_found, "no such file");
    fail_on(path_, Status::io, format("cannot be opened: %s", std::strerror(errno)));
  }
  struct stat info;
  const bool known = ::fstat(handle_, &info) == 0, regular = known && S_ISREG(info.st_mode);
  if (regular) size_ = static_cast<std::uint64_t>(info.st_size);
  if (regular && size_ <= limit) return;
  ::close(handle_);
  if (regular)
    fail_on(path_, Status::limit,
            format("larger than the limit of %llu bytes", static_cast<unsigned long long>(limit)));
  fail_on(path_, Status::io, known && S_ISDIR(info.st_mode) ? "is a directory, not a file" : "is no regular file");
}

InputFile::~InputFile() {
  ::close(handle_);
}

std::size_t InputFile::read_at(std::uint64_t offset, std::span<std::byte> to) const {
  std::size_t done = 0;
  while (done < to.size()) {
    const ssize_t got = ::pread(handle_, to.data() + done, to.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_on(path_, Status::io, format("reading failed: %s", std::strerror(errno)));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

}  // namespace fb
