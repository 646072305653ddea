#include "base/mapped_file.h"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>

#include "base/shown_path.h"

namespace fb {

MappedFile::MappedFile(const InputFile& file) {
  if (file.size() == 0) return;  // cannot be mapped
  const auto size = static_cast<std::size_t>(file.size());
  void* const first = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.handle(), 0);
  if (first == MAP_FAILED) fail_on(file.path(), Status::io, format("cannot be mapped: %s", std::strerror(errno)));
  bytes_ = {static_cast<const std::byte*>(first), size};
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace fb
