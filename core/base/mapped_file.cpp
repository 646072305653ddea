#include "base/mapped_file.h"

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>
#else
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#endif

#include "base/file.h"
#include "base/status.h"

namespace fb {
namespace {

// Empty if the file cannot be mapped, such as an empty one. Called for regular files only: opening a pipe has side
// effects.
#ifdef _WIN32

std::span<const std::byte> map(const std::filesystem::path& path) {
  std::span<const std::byte> bytes;
  const HANDLE file = CreateFileW(path.c_str(), GENERIC_READ, FILE_SHARE_READ | FILE_SHARE_DELETE, nullptr,
                                  OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (file == INVALID_HANDLE_VALUE) return bytes;
  LARGE_INTEGER size;
  if (GetFileSizeEx(file, &size) && size.QuadPart > 0) {
    if (const HANDLE mapping = CreateFileMappingW(file, nullptr, PAGE_READONLY, 0, 0, nullptr)) {
      if (const void* first = MapViewOfFile(mapping, FILE_MAP_READ, 0, 0, 0))
        bytes = {static_cast<const std::byte*>(first), static_cast<std::size_t>(size.QuadPart)};
      CloseHandle(mapping);
    }
  }
  CloseHandle(file);
  return bytes;
}

void unmap(std::span<const std::byte> bytes) {
  UnmapViewOfFile(bytes.data());
}

#else

std::span<const std::byte> map(const std::filesystem::path& path) {
  std::span<const std::byte> bytes;
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return bytes;
  struct stat info;
  if (::fstat(file, &info) == 0 && info.st_size > 0) {
    const auto size = static_cast<std::size_t>(info.st_size);
    void* const first = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file, 0);
    if (first != MAP_FAILED) bytes = {static_cast<const std::byte*>(first), size};
  }
  ::close(file);
  return bytes;
}

void unmap(std::span<const std::byte> bytes) {
  ::munmap(const_cast<std::byte*>(bytes.data()), bytes.size());
}

#endif
}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path, std::uint64_t limit) {
  std::error_code unreadable;
  if (std::filesystem::is_regular_file(path, unreadable)) bytes_ = map(path);
  if (bytes_.empty()) bytes_ = buffer_ = read_file(path, limit);
  if (bytes_.size() <= limit) return;
  unmap(bytes_);
  fail_too_large(path, limit);
}

MappedFile::~MappedFile() {
  if (buffer_.empty() && !bytes_.empty()) unmap(bytes_);
}

}  // namespace fb
