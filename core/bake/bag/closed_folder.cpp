#include "bake/bag/closed_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_entries = 1000000, most_folders_deep = 64;
constexpr int folder_flags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
constexpr int file_flags = O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;

ClosedFolder::Kind kind_of(const struct stat& info) {
  if (S_ISREG(info.st_mode)) return ClosedFolder::Kind::file;
  if (S_ISDIR(info.st_mode)) return ClosedFolder::Kind::folder;
  return S_ISLNK(info.st_mode) ? ClosedFolder::Kind::link : ClosedFolder::Kind::other;
}

std::string reason_of(int error) {
  if (error == ELOOP) return "is a symbolic link, which is not followed";
  return std::string("cannot be read: ") + std::strerror(error);
}

using OpenFolder = std::unique_ptr<DIR, int (*)(DIR*)>;

// The names in an open folder, but for "." and "..".
std::vector<std::string> names_in(OpenDescriptor folder) {
  const OpenFolder opened(::fdopendir(folder.get()), ::closedir);
  if (!opened) fail(Status::io, "%s", reason_of(errno).c_str());
  folder.release();
  std::vector<std::string> names;
  for (errno = 0; const dirent* entry = ::readdir(opened.get()); errno = 0) {
    const std::string name = entry->d_name;
    if (name != "." && name != "..") names.push_back(name);
    if (names.size() > most_entries) fail(Status::limit, "holds more than %zu files", most_entries);
  }
  if (errno != 0) fail(Status::io, "%s", reason_of(errno).c_str());
  return names;
}

}  // namespace

ClosedFolder::ClosedFolder(std::filesystem::path folder)
    : path_(std::move(folder)), folder_(::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (folder_.get() >= 0) return;
  if (errno == ENOENT) fail_on(path_, Status::not_found, "no such folder");
  fail_on(path_, Status::io, errno == ENOTDIR ? "is no folder" : reason_of(errno));
}

OpenDescriptor ClosedFolder::open(const std::string& path, int flags) const {
  OpenDescriptor inside;
  for (std::size_t begin = 0;;) {
    const std::size_t end = path.find('/', begin);
    const std::string part = path.substr(begin, end - begin);
    const bool last = end == std::string::npos;
    const int from = begin == 0 ? folder_.get() : inside.get();
    if (part.empty() || part == "." || part == "..") fail(Status::io, "does not lie in the folder");
    OpenDescriptor next(::openat(from, part.c_str(), last ? flags : folder_flags));
    if (next.get() < 0 && errno == ENOTDIR)
      errno = ELOOP;  // what is opened as a folder was listed as one, or is a link
    if (next.get() < 0) fail(Status::io, "%s", reason_of(errno).c_str());
    inside = std::move(next);
    if (last) return inside;
    begin = end + 1;
  }
}

std::vector<ClosedFolder::Entry> ClosedFolder::list(const Complain& complain, Progress& progress) const {
  std::vector<Entry> entries;
  std::vector<std::string> folders = {""};  // still to be read
  while (!folders.empty()) {
    const std::string folder = std::move(folders.back());
    folders.pop_back();
    progress.ask();
    try {
      const OpenDescriptor opened =
          folder.empty() ? OpenDescriptor(::openat(folder_.get(), ".", folder_flags)) : open(folder, folder_flags);
      if (opened.get() < 0) fail(Status::io, "%s", reason_of(errno).c_str());
      for (const std::string& name : names_in(OpenDescriptor(::fcntl(opened.get(), F_DUPFD_CLOEXEC, 0)))) {
        struct stat info;
        if (::fstatat(opened.get(), name.c_str(), &info, AT_SYMLINK_NOFOLLOW) != 0)
          fail(Status::io, "%s", reason_of(errno).c_str());
        const std::string path = folder.empty() ? name : folder + "/" + name;
        const Kind kind = kind_of(info);
        entries.push_back({path, kind, kind == Kind::file ? static_cast<std::uint64_t>(info.st_size) : 0});
        if (entries.size() > most_entries) fail(Status::limit, "holds more than %zu files", most_entries);
        if (kind != Kind::folder) continue;
        if (std::ranges::count(path, '/') < static_cast<std::ptrdiff_t>(most_folders_deep))
          folders.push_back(path);
        else
          complain(path, format("lies more than %zu folders deep", most_folders_deep));
      }
    } catch (const Error& error) {
      if (error.status() != Status::io) throw;
      complain(folder, error.what());
    }
  }
  std::ranges::sort(entries, {}, &Entry::path);
  return entries;
}

void ClosedFolder::read(const std::string& path, const Take& take) const {
  const OpenDescriptor file = open(path, file_flags);
  struct stat info;
  if (::fstat(file.get(), &info) != 0) fail(Status::io, "%s", reason_of(errno).c_str());
  if (!S_ISREG(info.st_mode)) fail(Status::io, "is no regular file");
  std::vector<std::byte> piece(read_piece_bytes);
  for (;;) {
    const ssize_t got = ::read(file.get(), piece.data(), piece.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(Status::io, "%s", reason_of(errno).c_str());
    if (got == 0) return;
    take({piece.data(), static_cast<std::size_t>(got)});
  }
}

std::string ClosedFolder::read_text(const std::string& path, std::uint64_t most) const {
  std::string text;
  read(path, [&](std::span<const std::byte> piece) {
    if (text.size() + piece.size() > most)
      fail(Status::limit, "has more than %llu bytes", static_cast<unsigned long long>(most));
    text.append(reinterpret_cast<const char*>(piece.data()), piece.size());
  });
  return text;
}

}  // namespace fb::bake
