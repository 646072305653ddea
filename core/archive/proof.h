// What an archive holds beside the model: its proof and its texts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fb::archive {

// Poses and the positions they evaluated to when the archive was made. A reader, a machine or a file is verified by
// evaluating them again: hashes and positions must agree bit for bit. All empty: the archive carries no proof.
struct Proof {
  std::vector<float> controls;          // poses x controls, in control order
  std::vector<std::uint64_t> hashes;    // per pose: hash64_of the positions of all vertices of the surface
  std::vector<std::uint32_t> vertices;  // a sample of vertices
  std::vector<float> positions;         // poses x sampled vertices x 3, to show how far a pose is off
  std::vector<float> frames = {};       // poses x sockets x 12
  std::vector<float> channels = {};     // poses x channels
  // Expected errors: poses x ExpectedErrors::count(), and how many controls are outside of what was trained.
  std::vector<float> errors = {};
  std::vector<std::uint32_t> outside = {};
  // Poses x twice the coarser levels: hashes of the positions at the levels of detail 1/2, 1, 3/2, ...
  std::vector<std::uint64_t> level_hashes = {};
  std::vector<std::uint64_t> joint_hashes = {};  // poses, of the frames of driven joints; empty without any
};

// Texts for people and reports. Empty: the archive does not have it.
struct ArchiveText {
  std::string licence;      // under which the face may be used
  std::string certificate;  // a JSON object: the errors measured when the face was baked, see FORMAT.md
};

}  // namespace fb::archive
