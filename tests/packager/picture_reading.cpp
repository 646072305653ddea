#include "picture_reading.h"

#include <doctest/doctest.h>

#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#include <stb/stb_image.h>

namespace fb::test {

Picture read_picture(const std::vector<std::byte>& png) {
  Picture picture;
  int channels = 0;
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels(
      stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(png.data()), static_cast<int>(png.size()), &picture.width,
                            &picture.height, &channels, 3),
      &stbi_image_free);
  REQUIRE(pixels);
  picture.pixels.assign(pixels.get(), pixels.get() + 3 * std::size_t(picture.width) * std::size_t(picture.height));
  return picture;
}

}  // namespace fb::test
