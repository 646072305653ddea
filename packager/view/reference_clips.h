// Where the vertices truly are: clips of the source that a face was baked of, for a page that shows errors.
#pragma once

#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <functional>
#include <string>
#include <vector>

namespace fb::tool {

struct ReferenceClip {
  std::uint32_t index = 0;   // in the source
  std::uint64_t frames = 0;  // the first of the clip
};

// The clips to show: those of split test that have positions, else those of validation, else all; as many frames, from
// the first of each on, as come to 256 MiB of positions.
std::vector<ReferenceClip> choose_reference_clips(const facebaker::SourceView& source);

// NumPy files: frames x controls, and frames x vertices x 3, which evaluates a live rig, and fails with interrupted
// within a tenth of a second, or a pose, after `stop` says so.
std::string reference_controls(const facebaker::SourceView& source, const ReferenceClip& clip);
std::string reference_points(const facebaker::SourceView& source, const ReferenceClip& clip,
                             const std::function<bool()>& stop);

// A JSON object for the page: the source's name, whether it is live, and its clips, whose files are called
// "N.controls.npy" and "N.points.npy" below `folder`.
std::string reference_json(const facebaker::SourceView& source, const std::vector<ReferenceClip>& clips,
                           const std::string& folder);

// The positions of one pose of a live rig, as bytes of float32 values, for controls given so; values outside their
// ranges are clamped. Fails with invalid_argument on any other number of bytes.
std::string reference_pose(const facebaker::SourceView& source, const std::string& controls);

}  // namespace fb::tool
