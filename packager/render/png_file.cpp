#include "render/png_file.h"

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
  struct Sink {
    AtomicFile& file;
    std::exception_ptr failure;
  } sink{file, nullptr};
  // stb is C: an exception is kept until it has returned.
  const auto write = [](void* context, void* data, int size) {
    Sink& to = *static_cast<Sink*>(context);
    try {
      to.file.write({static_cast<const std::byte*>(data), static_cast<std::size_t>(size)});
    } catch (...) {
      to.failure = std::current_exception();
    }
  };
  const int written = stbi_write_png_to_func(write, &sink, image.width, image.height, 3, image.pixels.data(),
                                             image.width * static_cast<int>(sizeof(Rgb)));
  if (sink.failure) std::rethrow_exception(sink.failure);
  if (!written)
    fail(Status::out_of_memory, "%s: no memory for an image of %d x %d", shown(path).c_str(), image.width,
         image.height);
  file.commit();
}

}  // namespace fb::tool
