// Any number of further controls for the sample face.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rig.h"

namespace rigs::dense {

// Each moves a place of its own out of the face, and less so, down to half as far, the further a control of the sample
// face acts: evenly drawn places, a centimetre and a half wide.
class Bumps {
 public:
  Bumps() = default;
  Bumps(const sample_face::Rig& rig, std::uint32_t count);

  std::size_t count() const { return first_.empty() ? 0 : first_.size() - 1; }
  // controls: of the bumps; sample: all of the sample face. points: of the sample face, posed.
  void add(const float* controls, const std::vector<float>& sample, std::vector<sample_face::Vec3>& points) const;
  // What a clip has for a bump: one in five follows a sine wave.
  float value_in_clip(std::size_t bump, std::size_t frame) const;

 private:
  struct Move {
    std::uint32_t vertex;
    sample_face::Vec3 by;
  };
  std::vector<std::uint32_t> first_;  // by bump, and one more: of its moves
  std::vector<Move> moves_;
};

}  // namespace rigs::dense
