#pragma once

#include <sys/types.h>

#include <filesystem>

namespace fb {

// Where an output goes: the path, or what it points at if it is a symbolic link, through any number of links; what the
// last one names may be missing. Fails with io on a circle of links.
std::filesystem::path resolve_links(const std::filesystem::path& path);

// The file that an output replaces, if there is one: its right to be read, written and executed, its owner and its
// group are those of the new one, as far as the system allows. Access control lists and extended attributes are not
// kept; other names of the file (hard links) keep the old one.
class ReplacedFile {
 public:
  // Fails with io, naming the path, if it is there and no regular file, such as a device or a folder, or may not be
  // written.
  explicit ReplacedFile(const std::filesystem::path& path);
  // Creates an empty file with these rights, which nobody else could open at any time; without a file to replace as the
  // process creates files (umask). False if there is a file of that name. Fails with io.
  bool create(const std::filesystem::path& path) const;

 private:
  bool exists_ = false;
  mode_t mode_ = 0666;
  uid_t owner_ = 0;
  gid_t group_ = 0;
};

}  // namespace fb
