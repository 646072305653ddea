// Files by the wide interface of Windows: std::filesystem::path is UTF-16 there.
#include <windows.h>

#include <algorithm>

#include "base/input_file.h"
#include "base/shown_path.h"
#include "base/windows_error.h"

namespace fb {

InputFile::InputFile(std::filesystem::path path, std::uint64_t limit) : path_(std::move(path)) {
  // Others may go on writing, renaming and removing it, as on other systems. Folders are opened only with
  // BACKUP_SEMANTICS, and refused with a reason of our own.
  handle_ = CreateFileW(path_.c_str(), GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr,
                        OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL | FILE_FLAG_BACKUP_SEMANTICS, nullptr);
  if (handle_ == INVALID_HANDLE_VALUE) {
    const DWORD error = GetLastError();
    if (error == ERROR_FILE_NOT_FOUND || error == ERROR_PATH_NOT_FOUND || error == ERROR_INVALID_NAME ||
        error == ERROR_BAD_NETPATH)
      fail_on(path_, Status::not_found, "no such file");
    fail_on(path_, Status::io, "cannot be opened: " + windows_reason(error));
  }
  BY_HANDLE_FILE_INFORMATION info;
  const bool known = GetFileType(handle_) == FILE_TYPE_DISK && GetFileInformationByHandle(handle_, &info);
  const bool folder = known && (info.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY), regular = known && !folder;
  if (regular) size_ = std::uint64_t(info.nFileSizeHigh) << 32 | info.nFileSizeLow;
  if (regular && size_ <= limit) return;
  CloseHandle(handle_);
  if (regular)
    fail_on(path_, Status::limit,
            format("larger than the limit of %llu bytes", static_cast<unsigned long long>(limit)));
  fail_on(path_, Status::io, folder ? "is a directory, not a file" : "is no regular file");
}

InputFile::~InputFile() {
  CloseHandle(handle_);
}

std::size_t InputFile::read_at(std::uint64_t offset, std::span<std::byte> to) const {
  constexpr std::size_t most = std::size_t(1) << 30;  // of one call, which counts in 32 bits
  std::size_t done = 0;
  while (done < to.size()) {
    OVERLAPPED at = {};
    at.Offset = static_cast<DWORD>(offset + done);
    at.OffsetHigh = static_cast<DWORD>((offset + done) >> 32);
    DWORD got = 0;
    if (!ReadFile(handle_, to.data() + done, static_cast<DWORD>(std::min(most, to.size() - done)), &got, &at)) {
      const DWORD error = GetLastError();
      if (error == ERROR_HANDLE_EOF) break;
      fail_on(path_, Status::io, "reading failed: " + windows_reason(error));
    }
    if (got == 0) break;
    done += got;
  }
  return done;
}

}  // namespace fb
