#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fb::archive {

// Poses evaluated when the archive was made. Whoever doubts a reader, a machine or a file evaluates them again and
// compares; see core/archive/FORMAT.md for what has to agree. All empty: the archive carries no proof.
struct Proof {
  std::vector<float> controls;          // poses x controls, in control order
  std::vector<std::uint64_t> hashes;    // of each pose: hash64_of its positions, of all vertices
  std::vector<std::uint32_t> vertices;  // some, whose positions are kept to show by how much a pose is off
  std::vector<float> positions;         // poses x those vertices x 3
};

// What people and reports read. Empty: the archive does not have it.
struct ArchiveText {
  std::string licence;      // under which the face may be used
  std::string certificate;  // a JSON object: the errors measured when the face was baked, see FORMAT.md
};

}  // namespace fb::archive
