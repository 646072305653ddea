#include "bake/sampling/drawn_clips.h"

#include "bake/rig/source_rules.h"
#include "bake/sampling/sampling.h"

namespace fb::bake {

DrawnClips::DrawnClips(std::unique_ptr<Source> source, std::uint64_t seed, std::size_t poses)
    : SourceDecorator(std::move(source)),
      clips_(make_test_poses(schema(), seed, poses)),
      note_(format("\"%s\" has no clips: %zu poses are drawn to measure on, of seed %llu", schema().name.c_str(), poses,
                   static_cast<unsigned long long>(seed))) {}

void DrawnClips::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  evaluate_clip(*this, clip, first, count, points);
}

std::vector<std::string> DrawnClips::notes() const {
  std::vector<std::string> notes = SourceDecorator::notes();
  notes.push_back(note_);
  return notes;
}

}  // namespace fb::bake
