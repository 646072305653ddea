#include "bake/sampling/validation_split.h"

#include <algorithm>
#include <cmath>

#include "bake/sampling/pose_generators.h"

namespace fb::bake {
namespace {

constexpr std::size_t max_segment_frames = 96;
// Of shots, a segment may be a fifth of all frames, where that is more than the share: neighbours in time of what is
// trained on tell little. On a rig of 303 controls, five takes of 60 frames, of which pieces of 15 were held back, told
// 0.58 to 0.94 of the rms error of other takes (four seeds); a whole take tells 0.83 to 1.05, and the faces are as
// good.
constexpr std::size_t shot_parts = 5;
// Consecutive frames belong to one sequence if they are closer than this share of the distance of unrelated frames.
constexpr double related_share = 0.5;

// Consecutive poses of the set, all of which are trained on or all validated with.
struct Segment {
  std::size_t first, count;
};

class SequenceSplitter {
 public:
  explicit SequenceSplitter(const PoseSet& poses) : schema_(poses.source().schema()), clips_(poses.source().clips()) {}

  // Appends the sequences of consecutive frames, cut into equal segments of at most `longest` frames.
  void split(const PoseSet::Range& range, std::size_t longest, std::vector<Segment>& segments) const {
    const bool shot = clips_[range.clip].kind == ClipKind::shot;  // one sequence, even across cuts
    const double gap = shot ? HUGE_VAL : related_share * typical_distance(range);
    for (std::size_t first = 0, end; first < range.count; first = end) {
      for (end = first + 1; end < range.count && distance(range, end - 1, end) < gap; ++end) {
      }
      const std::size_t parts = (end - first + longest - 1) / longest;
      for (std::size_t p = 0; p < parts; ++p) {
        const std::size_t from = first + p * (end - first) / parts, to = first + (p + 1) * (end - first) / parts;
        segments.push_back({range.first_pose + from, to - from});
      }
    }
  }

 private:
  // Between two frames of a range, each control in units of its reach.
  double distance(const PoseSet::Range& range, std::size_t a, std::size_t b) const {
    const std::size_t width = schema_.control_count();
    const float* values = clips_[range.clip].controls.data() + range.frame * width;
    double squares = 0;
    for (std::size_t c = 0; c < width; ++c) {
      const double d = (double(values[a * width + c]) - values[b * width + c]) / schema_.controls[c].reach();
      squares += d * d;
    }
    return std::sqrt(squares);
  }

  // The median distance of frames half the range apart, of at most 200 such pairs.
  double typical_distance(const PoseSet::Range& range) const {
    const std::size_t half = range.count / 2, pairs = std::min<std::size_t>(half, 200);
    if (pairs == 0) return 0;
    std::vector<double> distances;
    for (std::size_t i = 0; i < pairs; ++i)
      distances.push_back(distance(range, i * half / pairs, i * half / pairs + half));
    std::nth_element(distances.begin(), distances.begin() + pairs / 2, distances.end());
    return distances[pairs / 2];
  }

  const RigSchema& schema_;
  const std::vector<Clip>& clips_;
};

}  // namespace

ValidationSplit validation_split(const PoseSet& poses, double share, std::uint64_t seed) {
  if (!(share >= 0 && share < 1)) fail(Status::invalid_argument, "a validation share of %g is not in [0, 1)", share);
  const std::vector<Clip>& clips = poses.source().clips();
  std::vector<bool> is_validation(poses.size());
  const auto add_to_validation = [&](std::size_t first, std::size_t count) {
    std::fill_n(is_validation.begin() + static_cast<std::ptrdiff_t>(first), count, true);
  };
  const SequenceSplitter splitter(poses);
  for (const ClipKind kind : {ClipKind::shot, ClipKind::regional, ClipKind::calisthenics, ClipKind::dense}) {
    std::vector<const PoseSet::Range*> ranges;
    std::size_t frames = 0;
    for (const PoseSet::Range& range : poses.ranges())
      if (clips[range.clip].kind == kind && clips[range.clip].split == Split::train) {
        ranges.push_back(&range);
        frames += range.count;
      }
    const auto wanted = static_cast<std::size_t>(std::llround(share * static_cast<double>(frames)));
    const std::size_t enough = kind == ClipKind::shot && wanted > 0 ? frames / shot_parts : 0,
                      longest = std::clamp<std::size_t>(std::max(wanted, enough), 1, max_segment_frames);
    std::vector<Segment> segments;
    for (const PoseSet::Range* range : ranges) splitter.split(*range, longest, segments);
    Random random = open_stream(seed, Stream::validation, static_cast<std::uint64_t>(kind));
    for (std::size_t i = 0, taken = 0; i < segments.size() && taken < wanted; ++i) {
      std::swap(segments[i], segments[i + random.below(static_cast<std::uint32_t>(segments.size() - i))]);
      if (2 * (taken + segments[i].count) > frames) continue;
      add_to_validation(segments[i].first, segments[i].count);
      taken += segments[i].count;
    }
  }
  for (const PoseSet::Range& range : poses.ranges()) {
    const Clip& clip = clips[range.clip];
    if (clip.split == Split::test)
      fail(Status::invalid_argument, "clip \"%s\" is a test clip: it may not be used for any choice",
           clip.name.c_str());
    if (clip.split == Split::validation) add_to_validation(range.first_pose, range.count);
  }
  ValidationSplit split;
  for (std::size_t pose = 0; pose < poses.size(); ++pose)
    (is_validation[pose] ? split.validation : split.training).push_back(static_cast<std::uint32_t>(pose));
  return split;
}

TrainingPoses::TrainingPoses(const PoseSet& poses, std::uint64_t seed)
    : all(poses), split(validation_split(poses, 0.05, seed)) {}

}  // namespace fb::bake
