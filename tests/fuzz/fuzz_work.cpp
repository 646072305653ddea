// Feeds arbitrary bytes to what is read from work folders: checkpoints and evaluated poses, with their keys corrected.
#include <cmath>
#include <vector>

#include "bake/rig/content_hash.h"
#include "bake/rig/evaluation_cache.h"
#include "bake/train/checkpoint.h"
#include "fuzz_folder.h"
#include "memory_source.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const MemorySource rig(2, 2, [](const float*, std::span<float>) {});
  std::vector<unsigned char> bytes(data, data + size);
  fuzz::expect_message([&] {
    std::uint64_t key = 0;
    if (size >= sizeof key) std::memcpy(&key, data, sizeof key);
    fb::bake::load_checkpoint(fuzz::put("checkpoint", data, size), key);
  });
  fuzz::expect_message([&] {
    const std::uint64_t hash = fb::bake::ContentHash().add(rig).value;
    if (bytes.size() >= 16) {
      std::memcpy(bytes.data(), "fbeval01", 8);
      std::memcpy(&bytes[8], &hash, sizeof hash);
    }
    fb::bake::EvaluationCache cache(fuzz::put("rig.evaluations", bytes.data(), bytes.size()), rig);
    std::vector<float> pose(2), points(12, 1.0f);
    if (bytes.size() >= 32) std::memcpy(pose.data(), &bytes[24], 8);
    for (float& value : pose)
      if (!std::isfinite(value)) value = 0;  // as sources guarantee
    cache.find(pose, points);
    cache.store(pose, points);
    cache.flush();
    if (!cache.find(pose, points)) __builtin_trap();
  });
  return 0;
}
