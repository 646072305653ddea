#include "base/file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "base/input_file.h"
#include "base/status.h"

namespace fb {

std::vector<std::byte> read_file(const std::filesystem::path& path, std::uint64_t limit) {
  std::vector<std::byte> bytes;
  InputFile(path, limit).read_all(bytes);
  return bytes;
}

void make_folder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) fail(Status::io, "%s: cannot be created: %s", path.c_str(), error.message().c_str());
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code unreadable;
  const auto existing = std::filesystem::status(path_, unreadable);
  if (std::filesystem::is_directory(existing)) fail(Status::io, "%s: is a directory, not a file", path_.c_str());
  // Renaming would replace a device by a file.
  if (std::filesystem::exists(existing) && !std::filesystem::is_regular_file(existing))
    fail(Status::io, "%s: cannot be written: is not a regular file", path_.c_str());
  partial_ = path_;
  partial_ += ".partial-" + std::to_string(getpid());
  file_ = std::fopen(partial_.c_str(), "wb");
  if (!file_) fail(Status::io, "%s: cannot be written: %s", path_.c_str(), std::strerror(errno));
}

AtomicFile::~AtomicFile() {
  if (!file_) return;
  std::fclose(file_);
  ::unlink(partial_.c_str());
}

void AtomicFile::fail_here(const char* what) {
  fail(Status::io, "%s: %s: %s", path_.c_str(), what, std::strerror(errno));
}

void AtomicFile::write(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail_here("writing failed");
}

void AtomicFile::commit(const std::function<void(const std::filesystem::path&)>& check) {
  if (std::fflush(file_) != 0 || ::fsync(::fileno(file_)) != 0) fail_here("writing failed");
  if (check) check(partial_);
  if (std::rename(partial_.c_str(), path_.c_str()) != 0) fail_here("cannot be renamed into place");
  std::fclose(file_);
  file_ = nullptr;
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  write_file(path, std::as_bytes(std::span(text)));
}

}  // namespace fb
