// Pictures that the tool wrote.
#pragma once

#include <cstddef>
#include <vector>

namespace fb::test {

struct Picture {
  int width = 0, height = 0;
  std::vector<unsigned char> pixels;  // three bytes each, by rows
};

// Fails the test on what is no PNG.
Picture read_picture(const std::vector<std::byte>& png);

}  // namespace fb::test
