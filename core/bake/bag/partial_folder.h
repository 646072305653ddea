// A folder that appears under its name complete or not at all.
#pragma once

#include <filesystem>

#include "base/output_lock.h"

namespace fb::bake {

// Is filled under the name "<folder>.facebaker-partial" beside it, and renamed by commit(); the destructor removes an
// uncommitted one. Holds the lock of the folder meanwhile (OutputLock::of_file). What a killed process left under that
// name is removed.
class PartialFolder {
 public:
  // Fails with io if the folder is there and not empty, and as OutputLock does.
  explicit PartialFolder(const std::filesystem::path& folder);
  ~PartialFolder();
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  const std::filesystem::path& path() const { return partial_; }
  // Everything in it must be on the disk. Fails with io, and leaves nothing then.
  void commit();

 private:
  std::filesystem::path folder_, partial_;
  OutputLock lock_;
  bool committed_ = false;
};

}  // namespace fb::bake
