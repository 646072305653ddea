#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace fb {

#ifdef _WIN32
using FileHandle = void*;
#else
using FileHandle = int;  // a file descriptor
#endif

// A regular file open for reading. Everything else is refused at once: a directory, a pipe (which would wait for a
// writer), a device (which may never end). Fails with the path in the message: not_found if there is no such file, io
// if it is not a regular one or the system refuses.
class InputFile {
 public:
  // Fails with limit if the file has more than `limit` bytes.
  explicit InputFile(std::filesystem::path path, std::uint64_t limit = UINT64_MAX);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  FileHandle handle() const { return handle_; }
  // In bytes, when the file was opened.
  std::uint64_t size() const { return size_; }
  // Reads from byte `offset` on and returns how many bytes there were: fewer than asked for only at the end.
  std::size_t read_at(std::uint64_t offset, std::span<std::byte> to) const;
  // Reads the whole file into an empty vector: as many bytes as it had when it was opened, or fewer if it was cut
  // short.
  template <class Bytes>
  void read_all(Bytes& bytes) const {
    bytes.resize(static_cast<std::size_t>(size_));
    bytes.resize(read_at(0, bytes));
  }

 private:
  std::filesystem::path path_;
  FileHandle handle_;
  std::uint64_t size_ = 0;
};

}  // namespace fb
