// Feeds arbitrary bytes to what is read from work folders: checkpoints and evaluated poses, with their keys corrected.
#include <cmath>
#include <vector>

#include "bake/rig/evaluation_cache.h"
#include "bake/train/checkpoint.h"
#include "base/hash.h"
#include "fuzz_folder.h"
#include "memory_source.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const MemorySource rig(2, 2, [](const float*, std::span<float>) {});
  fuzz::expect_message([&] {
    std::uint64_t key = 0;
    if (size >= sizeof key) std::memcpy(&key, data, sizeof key);
    fb::bake::load_checkpoint(fuzz::put("checkpoint", data, size), key);
  });
  const fb::bake::RigIdentity identity = fb::bake::identity_of(rig);
  // A header's text, if it is to hold the same hash: anything.
  fuzz::expect_message([&] {
    std::vector<unsigned char> file(24 + size);
    const std::uint64_t fields[] = {0x3230'6c61'7665'6266, fb::hash64_of(std::span(data, size)), size};
    std::memcpy(file.data(), fields, sizeof fields);
    if (size > 0) std::memcpy(&file[24], data, size);
    fb::bake::EvaluationCache(fuzz::put("rig.evaluations", file.data(), file.size()), identity);
  });
  // Records behind the header of this rig.
  fuzz::expect_message([&] {
    const std::string text = fb::bake::text_of(identity);
    std::vector<unsigned char> file(24 + text.size() + size);
    const std::uint64_t fields[] = {0x3230'6c61'7665'6266, fb::hash64_of(std::span<const char>(text)), text.size()};
    std::memcpy(file.data(), fields, sizeof fields);
    std::memcpy(&file[24], text.data(), text.size());
    if (size > 0) std::memcpy(&file[24 + text.size()], data, size);
    fb::bake::EvaluationCache cache(fuzz::put("rig.evaluations", file.data(), file.size()), identity);
    std::vector<float> pose(2), points(12, 1.0f);
    if (size >= 24) std::memcpy(pose.data(), data + 16, 8);
    for (float& value : pose)
      if (!std::isfinite(value)) value = 0;  // as sources guarantee
    for (std::uint64_t record = 0; record < cache.record_count(); ++record) {
      std::vector<float> controls(2);
      cache.read(record, controls, points);
    }
    cache.find(pose, points);
    cache.store(pose, points);
    cache.flush();
    if (!cache.find(pose, points)) __builtin_trap();
  });
  return 0;
}
