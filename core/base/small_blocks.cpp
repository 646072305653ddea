#include "base/small_blocks.h"

#include <cstdint>
#include <cstring>
#include <new>

namespace fb {
namespace {

constexpr std::size_t chunk_alignment = alignof(std::max_align_t);

// Whether a block is cut from a chunk: so that what aligns it stays small beside it.
bool is_small(std::size_t bytes, std::size_t alignment) {
  return bytes <= SmallBlocks::largest && alignment <= 64;
}

}  // namespace

void* SmallBlocks::do_allocate(std::size_t bytes, std::size_t alignment) {
  if (!is_small(bytes, alignment)) return upstream_.allocate(bytes, alignment);
  const auto place = [&](const Chunk* chunk) {  // of the block, from the beginning of the chunk
    const auto begin = reinterpret_cast<std::uintptr_t>(chunk);
    const std::uintptr_t least = begin + chunk->used + sizeof(Chunk*);
    return static_cast<std::size_t>((least + alignment - 1) / alignment * alignment - begin);
  };
  if (!current_ || place(current_) + bytes > current_->size) {
    while (next_chunk_ < sizeof(Chunk) + sizeof(Chunk*) + alignment + bytes) next_chunk_ *= 2;
    current_ = new (upstream_.allocate(next_chunk_, chunk_alignment)) Chunk{next_chunk_, sizeof(Chunk), 0};
    if (next_chunk_ < last_chunk) next_chunk_ *= 2;
  }
  const std::size_t at = place(current_);
  std::byte* const block = reinterpret_cast<std::byte*>(current_) + at;
  std::memcpy(block - sizeof(Chunk*), &current_, sizeof(Chunk*));
  current_->used = at + bytes;
  ++current_->blocks;
  return block;
}

void SmallBlocks::do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) {
  if (!is_small(bytes, alignment)) return upstream_.deallocate(memory, bytes, alignment);
  Chunk* chunk;
  std::memcpy(&chunk, static_cast<std::byte*>(memory) - sizeof(Chunk*), sizeof(Chunk*));
  // The last block that was cut makes room again.
  if (static_cast<std::byte*>(memory) + bytes == reinterpret_cast<std::byte*>(chunk) + chunk->used)
    chunk->used = static_cast<std::size_t>(static_cast<std::byte*>(memory) - reinterpret_cast<std::byte*>(chunk));
  if (--chunk->blocks > 0) return;
  if (chunk == current_) {
    current_ = nullptr;
    next_chunk_ = first_chunk;
  }
  upstream_.deallocate(chunk, chunk->size, chunk_alignment);
}

}  // namespace fb
