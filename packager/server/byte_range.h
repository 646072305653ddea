#pragma once

#include <cstddef>
#include <string_view>

namespace fb::tool {

// What a Range header asks of a file (RFC 9110, section 14): 206, `count` bytes from `first` on, at least one and all
// within the file; 416, bytes that the file does not have; 200, the whole file.
struct RangeAnswer {
  int status = 200;
  std::size_t first = 0, count = 0;
};

// `header`: the value of Range, "" where there is none; `size`: bytes of the file. A range that ends beyond the file is
// clipped to it. A header that is malformed, of another unit or of several ranges is ignored, as the RFC allows.
RangeAnswer answer_range(std::string_view header, std::size_t size);

}  // namespace fb::tool
