#include "bake/check/check_points.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "bake/check/rest_comparison.h"
#include "bake/rig/source_rules.h"
#include "base/hash.h"
#include "base/vector3.h"

namespace fb::bake {
namespace {

constexpr std::size_t block_bytes = std::size_t{32} << 20;
constexpr double same = 1e-5;               // over the diagonal: what check_rest_pose allows
constexpr double near_rest = 0.5;           // over the diagonal: some frame of a face is nearer than that
constexpr std::size_t most_compared = 200;  // frames that are read again to see how far apart they are

struct Frame {
  std::size_t clip = 0, frame = 0;
  std::uint64_t controls = 0, points = 0;  // hashes
};

class PointsCheck {
 public:
  PointsCheck(const DatasetFiles& files, Findings& findings)
      : files_(files),
        findings_(findings),
        rest_(files.rest->points),
        schema_(files.index.schema),
        rest_pose_(schema_.rest_pose()),
        diagonal_(files.rest->diagonal()),
        alone_(schema_.control_count()) {
    seen_.vertex_motion.resize(rest_.size() / 3);
  }

  PointsSeen run(Progress& progress) {
    std::size_t all = 0, done = 0;
    for (const ClipFiles& clip : files_.clips) all += clip.points.rows();
    progress.begin(Phase::measuring, "checking points", all);
    for (std::size_t c = 0; c < files_.clips.size(); ++c) {
      const ClipFiles& clip = files_.clips[c];
      if (clip.points.rows() == 0) continue;
      bad_ = far_ = repeated_ = channels_ = {};
      findings_.attempt("points", clip.clip.name, [&] { read_clip(c, done, progress); });
      done += clip.points.rows();
      tell_clip(clip.clip);
    }
    tell_rest();
    tell_controls();
    return std::move(seen_);
  }

 private:
  // What is known of a control from frames in which it alone is off rest.
  struct Alone {
    std::size_t frames = 0;
    double motion = 0;
  };

  std::span<const float> controls_of(std::size_t clip, std::size_t frame) const {
    return frames_of(files_.clips[clip].clip, frame, 1, schema_.control_count());
  }

  void read_clip(std::size_t c, std::size_t done, Progress& progress) {
    const ClipFiles& clip = files_.clips[c];
    const std::size_t most = std::max<std::size_t>(1, block_bytes / (rest_.size() * sizeof(float)));
    std::vector<float> points;
    for (std::size_t first = 0; first < clip.points.rows(); first += most) {
      const std::size_t count = std::min(most, clip.points.rows() - first);
      points.resize(count * rest_.size());
      clip.points.read(first, count, points);
      for (std::size_t i = 0; i < count; ++i)
        look_at({c, first + i, hash64_of(controls_of(c, first + i))},
                std::span(points).subspan(i * rest_.size(), rest_.size()));
      read_channels(clip, first, count);
      progress.step(done + first + count);
    }
  }

  void read_channels(const ClipFiles& clip, std::size_t first, std::size_t count) {
    if (clip.channels.rows() == 0) return;
    const std::size_t width = schema_.channels.size() + files_.index.driven_number_count();
    const auto name = [&](std::size_t number) {
      return number < schema_.channels.size() ? "\"" + schema_.channels[number].name + "\""
                                              : format("number %zu of joints", number - schema_.channels.size());
    };
    std::vector<float> values(count * width);
    clip.channels.read(first, count, values);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i])) channels_.add(format("frame %zu %s", first + i / width, name(i % width).c_str()));
  }

  void look_at(Frame frame, std::span<const float> points) {
    ++seen_.frames;
    if (const auto fault = find_point_fault(points, *files_.rest, diagonal_)) {
      (fault->status == Status::not_finite ? bad_ : far_)
          .add(format("frame %zu, %s", frame.frame, fault->what.c_str()));
      seen_.frame_motion.push_back(0);
      return;
    }
    const double motion = measure_motion(points);
    if (motion < nearest_) {
      nearest_ = motion;
      nearest_frame_ = frame;
      nearest_points_.assign(points.begin(), points.end());
    }
    look_at_controls(frame, motion, points);
    frame.points = hash64_of(points);
    if (motion > same) compare_with_others(frame, points);
  }

  double measure_motion(std::span<const float> points) {
    const auto scale = static_cast<float>(1 / diagonal_);
    float largest = 0;
    for (std::size_t v = 0; v < seen_.vertex_motion.size(); ++v) {
      const float apart = length((vector_at(points.data(), v) - vector_at(rest_.data(), v)) * scale);
      seen_.vertex_motion[v] = std::max(seen_.vertex_motion[v], apart);
      largest = std::max(largest, apart);
    }
    seen_.frame_motion.push_back(largest);
    return largest;
  }

  void look_at_controls(const Frame& frame, double motion, std::span<const float> points) {
    const std::span<const float> controls = controls_of(frame.clip, frame.frame);
    std::size_t active = 0, last = 0;
    for (std::size_t c = 0; c < controls.size(); ++c)
      if (controls[c] != rest_pose_[c]) ++active, last = c;
    if (active == 0) look_at_rest(frame, motion, points);
    if (active != 1) return;
    ++alone_[last].frames;
    alone_[last].motion = std::max(alone_[last].motion, motion);
  }

  void look_at_rest(const Frame& frame, double motion, std::span<const float> points) {
    ++rest_frames_;
    if (motion <= std::max(same, rest_off_)) return;
    rest_off_ = motion;
    rest_frame_ = frame;
    off_rest_.assign(points.begin(), points.end());
  }

  // Frames with other controls and these points, or with these controls and other points.
  void compare_with_others(const Frame& frame, std::span<const float> points) {
    const auto [alike, fresh_points] = by_points_.emplace(frame.points, frame);
    if (!fresh_points && alike->second.controls != frame.controls)
      repeated_.add(format("frame %zu has the points of %s", frame.frame, address(alike->second).c_str()));
    const auto [pose, fresh_controls] = by_controls_.emplace(frame.controls, frame);
    if (fresh_controls || pose->second.points == frame.points || compared_++ >= most_compared) return;
    const Frame& other = pose->second;
    std::vector<float> before(points.size());
    files_.clips[other.clip].points.read(other.frame, 1, before);
    const double apart = distance_from(before, points, diagonal_).largest;
    if (apart > same)
      unlike_.add(format("%s and %s, %.2g apart", address(other).c_str(), address(frame).c_str(), apart));
  }

  std::string address(const Frame& frame) const {
    return format("clip \"%s\", frame %zu", files_.clips[frame.clip].clip.name.c_str(), frame.frame);
  }

  void tell_clip(const Clip& clip) {
    const char* name = clip.name.c_str();
    const auto tell = [&](const char* kind, bool fault, const Examples& found, const char* what) {
      if (found.count() == 0) return;
      std::string text = format("clip \"%s\": %zu %s: %s", name, found.count(), what, found.text().c_str());
      fault ? findings_.fault(kind, clip.name, std::move(text)) : findings_.warn(kind, clip.name, std::move(text));
    };
    tell("not_finite", true, bad_, "frames have points that are not finite");
    tell("far", true, far_, "frames have points too far from the rest mesh");
    tell("not_finite", true, channels_, "values of channels are not finite");
    tell("repeated", false, repeated_,
         "frames have the points of another pose, as if the scene had not been evaluated after controls were set");
  }

  // What explains a frame that ought to be near the rest mesh, as the end of a sentence.
  std::string because(std::span<const float> points, double tolerance) const {
    const std::string why = explain_distance(rest_, points, tolerance);
    return why.empty() ? "" : "; " + why;
  }

  void tell_rest() {
    if (rest_off_ > 0) {
      const RestDistance worst = distance_from(rest_, off_rest_, diagonal_);
      findings_.warn(
          "rest", files_.clips[rest_frame_.clip].clip.name,
          format("%s: all controls are at rest, but the points are not the rest mesh: vertex %zu is %.3g of "
                 "the diagonal away%s",
                 address(rest_frame_).c_str(), worst.vertex, worst.largest, because(off_rest_, 1e-3).c_str()));
    } else if (seen_.frames > 0 && rest_frames_ == 0) {
      findings_.warn("rest", "",
                     "no frame has all controls at rest: whether the points fit the rest mesh is not known");
    }
    if (rest_frames_ == 0 && seen_.frames > 0 && std::isfinite(nearest_) && nearest_ > near_rest)
      findings_.warn("rest", files_.clips[nearest_frame_.clip].clip.name,
                     format("the points fit no rest mesh: even those of %s are %.3g of the diagonal away%s",
                            address(nearest_frame_).c_str(), nearest_, because(nearest_points_, 0.2).c_str()));
    if (unlike_.count() > 0)
      findings_.warn("unlike", "",
                     format("%zu poses have other points each time, as if the rig remembered what came before: %s",
                            unlike_.count(), unlike_.text().c_str()));
  }

  void tell_controls() {
    Examples still;
    for (std::size_t c = 0; c < alone_.size(); ++c)
      if (alone_[c].frames > 0 && alone_[c].motion <= 1e-7) still.add("\"" + schema_.controls[c].name + "\"");
    if (still.count() > 0)
      findings_.warn("still", "",
                     format("%zu controls, moved alone, move nothing: %s", still.count(), still.text().c_str()));
  }

  const DatasetFiles& files_;
  Findings& findings_;
  const std::vector<float>& rest_;
  const RigSchema& schema_;
  const std::vector<float> rest_pose_;
  const double diagonal_;
  PointsSeen seen_;
  std::vector<Alone> alone_;
  Examples bad_, far_, repeated_, channels_;  // of the current clip
  Examples unlike_;
  std::unordered_map<std::uint64_t, Frame> by_points_, by_controls_;
  std::size_t compared_ = 0, rest_frames_ = 0;
  double rest_off_ = 0, nearest_ = INFINITY;
  Frame rest_frame_, nearest_frame_;
  std::vector<float> off_rest_, nearest_points_;
};

}  // namespace

PointsSeen check_points(const DatasetFiles& files, Findings& findings, Progress& progress) {
  if (!files.rest || files.index.schema.controls.empty()) return {};
  return PointsCheck(files, findings).run(progress);
}

}  // namespace fb::bake
