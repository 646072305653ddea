// A slow rig's own clips, in part.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source_decorator.h"

namespace fb::bake {

// Another source, whose clips of one split have so many frames at most. Where they have more, every clip gives its
// share in stretches of about 32 consecutive frames, evenly spaced over it; each stretch is a clip of its own, called
// "CLIP [FIRST-LAST]" by its frames. A clip whose share is less than a frame is left out.
class LimitedClips final : public SourceDecorator {
 public:
  // `frames`: of each split, at least 1.
  LimitedClips(std::unique_ptr<Source> source, std::uint64_t frames);

  const std::vector<Clip>& clips() const override { return clips_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool readable(std::size_t clip) const override { return source().readable(origins_.at(clip).clip); }
  bool recorded(std::size_t clip) const override { return source().recorded(origins_.at(clip).clip); }

 private:
  // Where a clip begins in the source.
  struct Origin {
    std::size_t clip, frame;
  };

  void add(std::size_t clip, std::size_t first, std::size_t count);
  void add_stretches(std::size_t clip, std::size_t frames);

  std::vector<Clip> clips_;
  std::vector<Origin> origins_;
};

}  // namespace fb::bake
