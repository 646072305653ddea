#pragma once

#include <filesystem>

#include "base/locked_file.h"

namespace fb {

// Reserves an output for one run at a time: whoever writes a file or a folder for longer than one write_file holds its
// lock, so that two runs never mix theirs. The lock is a LockedFile, "<file>.facebaker-lock" or
// "<folder>/.facebaker-lock", in which process, machine, time and command are written; it is removed with this object.
// One left behind by a process that was killed is nobody's and is taken over. Where the file system has no locks, it
// must be removed by hand; the message says so.
class OutputLock {
 public:
  // Fails with io, naming the holder, if another run has it, and as LockedFile does.
  static OutputLock of_file(const std::filesystem::path& path);
  // Creates the folder and its parents if need be, and removes partial files (see AtomicFile) of killed processes.
  static OutputLock of_folder(const std::filesystem::path& folder);
  // For those that read a folder, and take no lock: fails with io, naming the holder, if a run is writing it.
  static void refuse_if_written(const std::filesystem::path& folder);

  OutputLock(OutputLock&&) = default;
  OutputLock& operator=(OutputLock&&) = default;
  ~OutputLock();

  const std::filesystem::path& path() const { return file_.path(); }  // of the lock itself

 private:
  OutputLock(const std::filesystem::path& output, const std::filesystem::path& lock);

  LockedFile file_;
};

}  // namespace fb
