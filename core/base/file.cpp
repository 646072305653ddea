#include "base/file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "base/input_file.h"
#include "base/replaced_file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb {
namespace {

constexpr const char* partial_suffix = ".facebaker-partial";

std::filesystem::path parent_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : ".";
}

}  // namespace

std::vector<std::byte> read_file(const std::filesystem::path& path, std::uint64_t limit) {
  std::vector<std::byte> bytes;
  InputFile(path, limit).read_all(bytes);
  return bytes;
}

void make_folder(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> missing;
  std::error_code error;
  for (auto folder = path; !folder.empty() && !std::filesystem::is_directory(folder, error);) {
    missing.push_back(folder);
    folder = folder.parent_path();
  }
  for (; !missing.empty(); missing.pop_back()) {
    const std::filesystem::path& folder = missing.back();
    const bool made = std::filesystem::create_directory(folder, error);
    if (error) fail(Status::io, "%s: cannot be created: %s", shown(path).c_str(), error.message().c_str());
    if (made) sync_folder(parent_of(folder));
  }
}

void remove_folder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove_all(path, error);
  if (error) fail(Status::io, "%s: cannot be removed: %s", shown(path).c_str(), error.message().c_str());
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(resolve_links(path)) {
  const ReplacedFile replaced(path_);
  partial_ = path_;
  partial_ += partial_suffix;
  while (!file_) {
    const bool created = replaced.create(partial_);
    file_ = LockedFile::open(partial_, LockedFile::Missing::create);
    if (!file_) fail(Status::io, "%s: is being written by another process", shown(path_).c_str());
    if (created) break;
    file_->remove();  // left behind by a killed process, with rights of its own
    file_.reset();
  }
}

AtomicFile::~AtomicFile() {
  if (file_) file_->remove();
}

void AtomicFile::write(std::span<const std::byte> bytes) {
  file_->write(bytes);
}

void AtomicFile::commit(const std::function<void(const std::filesystem::path&)>& check) {
  file_->sync();
  if (check) check(partial_);
  if (std::rename(partial_.c_str(), path_.c_str()) != 0)
    fail(Status::io, "%s: cannot be renamed into place: %s", shown(path_).c_str(), std::strerror(errno));
  file_.reset();
  sync_folder(parent_of(path_));
}

void remove_partial_files(const std::filesystem::path& folder) {
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    if (!entry->path().native().ends_with(partial_suffix) || !entry->is_regular_file(gone)) continue;
    auto file = LockedFile::open(entry->path(), LockedFile::Missing::leave);
    if (file && file->exclusive()) file->remove();
  }
  if (error) fail(Status::io, "%s: cannot be read: %s", shown(folder).c_str(), error.message().c_str());
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
