#include "bench/counted_memory.h"

#include <atomic>
#include <new>

namespace fb::tool {
namespace {

// Memory of the C++ library, whose bytes are counted while they are taken.
class CountedMemory {
 public:
  fb_allocator allocator() { return {this, allocate, release}; }
  std::size_t bytes() const { return bytes_; }

 private:
  static void* allocate(void* self, std::size_t bytes, std::size_t alignment) {
    static_cast<CountedMemory*>(self)->bytes_ += bytes;
    return ::operator new(bytes, std::align_val_t(alignment), std::nothrow);
  }
  static void release(void* self, void* memory, std::size_t bytes, std::size_t alignment) {
    static_cast<CountedMemory*>(self)->bytes_ -= bytes;
    ::operator delete(memory, std::align_val_t(alignment));
  }

  std::atomic<std::size_t> bytes_ = 0;
};

}  // namespace

ScratchBytes scratch_bytes(const fb_archive_info& archive) {
  CountedMemory memory;
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.allocator = memory.allocator();
  const facebaker::Model model(archive.bytes, archive.byte_count, &desc);
  const auto bytes_of = [&](auto create) {
    const std::size_t before = memory.bytes();
    fb_scratch* scratch = nullptr;
    facebaker::check(create(model.get(), 1, &scratch));
    const std::size_t bytes = memory.bytes() - before;
    fb_scratch_destroy(scratch);
    return bytes;
  };
  return {bytes_of(fb_scratch_create), bytes_of(fb_scratch_create_single)};
}

}  // namespace fb::tool
