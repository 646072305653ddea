#pragma once

#include <cstddef>
#include <memory_resource>

namespace fb {

// Memory of another resource, asked for rarely: small blocks are cut from chunks, which go back when all their blocks
// have; larger ones are passed on. Not thread-safe.
class SmallBlocks final : public std::pmr::memory_resource {
 public:
  // Chunks are of the first size, then twice as large each, up to the last. Blocks beyond `largest` are passed on.
  static constexpr std::size_t first_chunk = 4 << 10, last_chunk = 64 << 10, largest = last_chunk / 8;

  // `upstream` must outlive it, and all blocks must be returned before it ends.
  explicit SmallBlocks(std::pmr::memory_resource& upstream) : upstream_(upstream) {}
  SmallBlocks(const SmallBlocks&) = delete;
  SmallBlocks& operator=(const SmallBlocks&) = delete;

 private:
  // At the beginning of a chunk. Before each block stands the address of its chunk.
  struct Chunk {
    std::size_t size, used, blocks;  // bytes; bytes from the beginning; blocks that have not been returned
  };

  void* do_allocate(std::size_t bytes, std::size_t alignment) override;
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override;
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  std::pmr::memory_resource& upstream_;
  Chunk* current_ = nullptr;  // that blocks are cut from
  std::size_t next_chunk_ = first_chunk;
};

}  // namespace fb
