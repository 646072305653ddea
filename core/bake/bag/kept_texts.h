// The texts that every bag has: what it is, the format of archives, and a reader of it.
#pragma once

#include <span>
#include <string_view>

namespace fb::bake {

struct KeptText {
  const char* path;  // in data/ of a bag
  std::string_view text;
};

// As they were when the library was built, whose files are listed in CMakeLists.txt. By path.
std::span<const KeptText> kept_texts();

}  // namespace fb::bake
