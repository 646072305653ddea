// Poses that a user names, to be kept exact.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bake/rig/source.h"
#include "base/progress.h"

namespace fb::bake {

struct NamedFrame {
  std::string name;             // unique: "CLIP:FRAME" or "FILE:LINE", both counted from 0
  std::vector<float> controls;  // within their ranges
  std::optional<std::size_t> clip = {};
  std::size_t frame = 0;  // of the clip
};

// The poses that `wanted` names, each of which is
//   CLIP, all frames of a clip of the source;
//   CLIP:FRAME[,FRAME...], some of them, counted from 0;
//   FILE, a .csv or .npy of controls as read_examples reads them, of a live source.
// Poses at rest, and those whose controls are within a millionth of their ranges of those of a pose before, are left
// out with a note; so is said which are frames that the face is to be measured on as unseen. Fails with not_found,
// naming the closest clip; with invalid_argument on a frame that the clip lacks, and on a file for a recording; with
// limit on more than max_exact_poses.
std::vector<NamedFrame> find_named_frames(const std::vector<std::string>& wanted, const Source& source,
                                          Progress& progress);

}  // namespace fb::bake
