#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "base/large_pages.h"

namespace test_large_pages {

using namespace fb;

TEST_CASE("large pages return aligned, adjacent blocks that stay valid until the arena is destroyed") {
  LargePages pages;
  const auto address = [](const void* memory) { return reinterpret_cast<std::uintptr_t>(memory); };
  struct Piece {
    unsigned char* first;
    std::size_t size;
  };
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < 40; ++i) {
    const std::size_t size = i == 7 ? LargePages::page + 1 : (i + 1) * 12345, alignment = std::size_t(1) << i % 8;
    auto* const first = static_cast<unsigned char*>(pages.allocate(size, alignment));
    CHECK(address(first) % alignment == 0);
    std::memset(first, static_cast<int>(i), size);
    pieces.push_back({first, size});
    if (i % 5 == 0) pages.deallocate(first, size, alignment);
  }
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    CHECK(pieces[i].first[0] == i);
    CHECK(pieces[i].first[pieces[i].size - 1] == i);
  }
  CHECK(address(pieces[0].first) % LargePages::page == 0);
  CHECK(pieces[1].first == pieces[0].first + pieces[0].size + 1);
}

}  // namespace test_large_pages
