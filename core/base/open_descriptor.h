#pragma once

#include <unistd.h>

#include <utility>

namespace fb {

// Owns a file descriptor; -1: none.
class OpenDescriptor {
 public:
  explicit OpenDescriptor(int descriptor = -1) : descriptor_(descriptor) {}
  OpenDescriptor(OpenDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  OpenDescriptor& operator=(OpenDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~OpenDescriptor() { reset(); }
  int get() const { return descriptor_; }
  int release() { return std::exchange(descriptor_, -1); }
  void reset() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  }

 private:
  int descriptor_;
};

}  // namespace fb
