#include "render/png_file.h"

#include <cstdlib>
#include <new>

// Memory for stb, which does not look whether there is any. What it holds when there is none stays lost.
static void* take_memory(void* before, std::size_t bytes) {
  void* const memory = std::realloc(before, bytes);
  if (!memory) throw std::bad_alloc();
  return memory;
}

#define STBIW_MALLOC(bytes) take_memory(nullptr, bytes)
#define STBIW_REALLOC(before, bytes) take_memory(before, bytes)
#define STBIW_FREE(memory) std::free(memory)
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {

void write_png(const std::filesystem::path& path, const Image& image) {
  AtomicFile file(path);
  const auto write = [](void* to, void* data, int size) {
    static_cast<AtomicFile*>(to)->write({static_cast<const std::byte*>(data), static_cast<std::size_t>(size)});
  };
  const int written = stbi_write_png_to_func(write, &file, image.width, image.height, 3, image.pixels.data(),
                                             image.width * static_cast<int>(sizeof(Rgb)));
  if (!written) fail(Status::internal, "%s: stb refused to write it", shown(path).c_str());
  file.commit();
}

}  // namespace fb::tool
