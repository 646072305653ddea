#include <windows.h>

#include "base/mapped_file.h"
#include "base/shown_path.h"
#include "base/windows_error.h"

namespace fb {

MappedFile::MappedFile(const InputFile& file) {
  if (file.size() == 0) return;  // cannot be mapped
  const HANDLE mapping = CreateFileMappingW(file.handle(), nullptr, PAGE_READONLY, 0, 0, nullptr);
  void* const first = mapping ? MapViewOfFile(mapping, FILE_MAP_READ, 0, 0, 0) : nullptr;
  const DWORD error = GetLastError();
  if (mapping) CloseHandle(mapping);  // the view holds it
  if (!first) fail_on(file.path(), Status::io, "cannot be mapped: " + windows_reason(error));
  bytes_ = {static_cast<const std::byte*>(first), static_cast<std::size_t>(file.size())};
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) UnmapViewOfFile(bytes_.data());
}

}  // namespace fb
