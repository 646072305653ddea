#pragma once

#include <cstddef>
#include <span>

#include "base/input_file.h"

namespace fb {

// The bytes of a file for the life of this object, mapped read-only and shared between processes. The file must be
// neither truncated nor overwritten meanwhile: the system ends processes that read beyond the new end. Replacing it by
// renaming, as AtomicFile does, is safe. Fails with io if the system cannot map it.
class MappedFile {
 public:
  explicit MappedFile(const InputFile& file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace fb
