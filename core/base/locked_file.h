#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>

namespace fb {

// A file open for writing that at most one LockedFile has at a time, in this process or any other. The system releases
// the lock when the process ends, however it ends. Also between machines where a network file system passes locks on
// (NFS, SMB). All system calls of writing are in locked_file.cpp; on Windows, a file opened without FILE_SHARE_WRITE
// would be the same.
class LockedFile {
 public:
  enum class Missing { create, leave };

  // Nothing if another has it or, with Missing::leave, if it is not there. Contents are kept. Fails with io, naming
  // the path, where it cannot be opened for writing or is no regular file; links are not followed.
  static std::optional<LockedFile> open(const std::filesystem::path& path, Missing missing);
  // Whether another has it; perhaps: the file system has no locks, and the file is not empty. Needs no right to write
  // it; no if it is not there. Fails with io where it cannot be read.
  enum class Held { no, yes, perhaps };
  static Held held(const std::filesystem::path& path);

  LockedFile(LockedFile&& other) noexcept;
  LockedFile& operator=(LockedFile&& other) noexcept;
  ~LockedFile();  // closes it and releases the lock

  const std::filesystem::path& path() const { return path_; }
  // False where the file system has no locks: then others may have it too.
  bool exclusive() const { return exclusive_; }
  bool empty() const;

  // These fail with io, naming the path and the system's reason.
  void clear();
  void write(std::span<const std::byte> bytes);
  void sync();  // to the disk
  // While it is locked: nobody else's file of this name is removed. Does nothing if it was removed already; never
  // fails.
  void remove() noexcept;

 private:
  LockedFile(std::filesystem::path path, int descriptor, bool exclusive)
      : path_(std::move(path)), descriptor_(descriptor), exclusive_(exclusive) {}
  [[noreturn]] void fail_here(const char* what) const;

  std::filesystem::path path_;
  int descriptor_;
  bool exclusive_;
};

// Makes the names in a folder durable: after a rename, a power failure leaves the new file. Does nothing where the
// system cannot do it for folders. Fails with io.
void sync_folder(const std::filesystem::path& folder);

}  // namespace fb
