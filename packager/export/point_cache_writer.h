#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/file.h"

namespace fb::tool {

enum class PointCache { mdd, pc2 };

// Writes positions over time as a point cache, frame by frame, in the layouts of docs/datasets.md. The file appears
// complete, or not at all unless finish() is called.
class PointCacheWriter {
 public:
  // fps: MDD has the time of each frame, frame / fps seconds. Fails with limit on counts beyond 32 bits with a sign.
  PointCacheWriter(const std::filesystem::path& path, PointCache kind, std::size_t frames, std::size_t points,
                   double fps);

  // The next frames: 3 x points floats each.
  void add(std::span<const float> positions);
  void finish() { file_.commit(); }

 private:
  AtomicFile file_;
  PointCache kind_;
};

}  // namespace fb::tool
