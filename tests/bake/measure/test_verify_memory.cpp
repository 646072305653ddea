// What measuring the rounding of a face takes of memory does not grow with the poses it is measured in.
#include <doctest/doctest.h>

#include <atomic>
#include <memory_resource>

#include "../compress/blockwise_toy.h"
#include "bake/compress/pack_model.h"
#include "bake/measure/verify.h"

namespace test_verify_memory {

using namespace fb;
using namespace fb::bake;

namespace {

// Counts what is taken of the default resource, as workspaces are.
class Counted final : public std::pmr::memory_resource {
 public:
  Counted() { std::pmr::set_default_resource(this); }
  ~Counted() override { std::pmr::set_default_resource(nullptr); }
  std::size_t bytes() const { return bytes_; }

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    bytes_ += bytes;
    return std::pmr::new_delete_resource()->allocate(bytes, alignment);
  }
  void do_deallocate(void* at, std::size_t bytes, std::size_t alignment) override {
    std::pmr::new_delete_resource()->deallocate(at, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  std::atomic<std::size_t> bytes_{0};
};

std::vector<float> controls_of(std::size_t count) {
  Random random(4);
  std::vector<float> controls(count * feature_count);
  for (float& value : controls) value = random.uniform();
  return controls;
}

}  // namespace

TEST_CASE("rounding is measured in the memory of a pose a worker, however many poses there are") {
  const FaceModel model = bumpy_model();
  const PackedModel packed = pack_model(model, {});
  const auto bytes = [&](std::size_t count) {
    const Counted counted;
    quantisation_errors(model, packed, controls_of(count), {.threads = 2});
    return counted.bytes();
  };
  const std::size_t few = bytes(4);
  CHECK(few > 0);
  CHECK(bytes(64) == few);

  const auto bytes_of_two = [&](std::size_t count) {
    const Counted counted;
    CHECK(quantisation_errors(packed, packed, controls_of(count)).max == 0);
    return counted.bytes();
  };
  CHECK(bytes_of_two(64) == bytes_of_two(4));
}

}  // namespace test_verify_memory
