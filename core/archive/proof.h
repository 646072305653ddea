#pragma once

#include <cstdint>
#include <vector>

namespace fb {

// Poses evaluated when the archive was made. Whoever doubts a reader, a machine or a file evaluates them again and
// compares; see core/archive/FORMAT.md for what has to agree. All empty: the archive carries no proof.
struct Proof {
  std::vector<float> controls;          // poses x controls, in control order
  std::vector<std::uint32_t> vertices;  // the vertices whose positions are kept
  std::vector<float> positions;         // poses x vertices x 3
};

}  // namespace fb
