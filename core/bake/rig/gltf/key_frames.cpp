#include "bake/rig/gltf/key_frames.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "base/status.h"

namespace fb::bake {
namespace {

// Values of a track at a time, in seconds; a time this near to a key is that key.
class TrackSampler {
 public:
  TrackSampler(const KeyTrack& track, double near) : track_(track), near_(near) {}

  void move_to(double time) {
    const std::vector<float>& times = track_.times;
    const auto after = std::upper_bound(times.begin(), times.end(), time + near_);
    key_ = after == times.begin() ? 0 : static_cast<std::size_t>(after - times.begin()) - 1;
    next_ = std::min(key_ + 1, times.size() - 1);
    const double passed = time - times[key_];
    const bool at_key = track_.interpolation == Interpolation::step || next_ == key_ || passed < near_;
    seconds_ = double(times[next_]) - times[key_];
    share_ = at_key ? 0 : passed / seconds_;
  }

  float value(std::size_t i) const {
    const double from = stored(key_, 1, i), to = stored(next_, 1, i), t = share_;
    if (t == 0) return static_cast<float>(from);
    if (track_.interpolation == Interpolation::linear && track_.rotation) return static_cast<float>(between(i));
    if (track_.interpolation == Interpolation::linear) return static_cast<float>((1 - t) * from + t * to);
    // glTF 2.0, appendix C.5: a Hermite spline.
    const double t2 = t * t, t3 = t2 * t;
    return static_cast<float>((2 * t3 - 3 * t2 + 1) * from + seconds_ * (t3 - 2 * t2 + t) * stored(key_, 2, i) +
                              (3 * t2 - 2 * t3) * to + seconds_ * (t3 - t2) * stored(next_, 0, i));
  }

 private:
  // A number of the quaternion between two keys: spherical linear interpolation, glTF 2.0, appendix C.4.
  double between(std::size_t i) const {
    const auto at = [&](std::size_t key) {
      return Eigen::Quaterniond(stored(key, 1, 3), stored(key, 1, 0), stored(key, 1, 1), stored(key, 1, 2))
          .normalized();
    };
    return at(key_).slerp(share_, at(next_)).coeffs()[static_cast<Eigen::Index>(i)];
  }

  // `which`: 0 in-tangent, 1 value, 2 out-tangent, of which all but the value is stored for splines only.
  double stored(std::size_t key, std::size_t which, std::size_t i) const {
    const std::size_t width = track_.controls.size();
    return track_.interpolation == Interpolation::cubic ? track_.values[(3 * key + which) * width + i]
                                                        : track_.values[key * width + i];
  }

  const KeyTrack& track_;
  double near_;
  std::size_t key_ = 0, next_ = 0;
  double seconds_ = 0, share_ = 0;  // from key to next
};

}  // namespace

double most_values(std::span<const KeyTrack> tracks) {
  double of_keys = 0;
  for (const KeyTrack& track : tracks) of_keys += static_cast<double>(track.values.size());
  return std::clamp(256 * of_keys, double(1 << 24), double(1 << 27));
}

double frame_count(std::span<const KeyTrack> tracks, double fps) {
  double start = INFINITY, end = -INFINITY;
  for (const KeyTrack& track : tracks) {
    start = std::min<double>(start, track.times.front());
    end = std::max<double>(end, track.times.back());
  }
  return std::ceil((end - start) * fps) + 1;
}

Clip resample(std::span<const KeyTrack> tracks, std::span<const float> rest, const FrameRate& rate,
              std::vector<std::size_t>& contested) {
  constexpr std::size_t none = SIZE_MAX;
  constexpr float same = 1e-5f;
  const double fps = rate.fps, near = rate.near;
  double start = INFINITY, end = -INFINITY;
  std::vector<std::size_t> mover(rest.size(), none);
  for (std::size_t k = 0; k < tracks.size(); ++k) {
    start = std::min<double>(start, tracks[k].times.front());
    end = std::max<double>(end, tracks[k].times.back());
    for (const std::size_t control : tracks[k].controls)
      if (mover[control] == none) mover[control] = k;
  }
  const double frames = std::ceil((end - start - near) * fps) + 1;
  if (frames * static_cast<double>(rest.size()) > most_values(tracks))
    fail(Status::limit, "%g s of %zu values are too long to be read", end - start, rest.size());

  Clip clip;
  clip.fps = fps;
  clip.frames = static_cast<std::size_t>(frames);
  clip.controls.reserve(clip.frames * rest.size());
  for (std::size_t f = 0; f < clip.frames; ++f) clip.controls.insert(clip.controls.end(), rest.begin(), rest.end());
  std::set<std::size_t> differing;
  for (std::size_t k = 0; k < tracks.size(); ++k) {
    TrackSampler sampler(tracks[k], near);
    for (std::size_t f = 0; f < clip.frames; ++f) {
      sampler.move_to(std::min(start + static_cast<double>(f) / fps, end));
      for (std::size_t i = 0; i < tracks[k].controls.size(); ++i) {
        const std::size_t control = tracks[k].controls[i];
        float& value = clip.controls[f * rest.size() + control];
        if (mover[control] == k)
          value = sampler.value(i);
        else if (std::abs(value - sampler.value(i)) > same)
          differing.insert(control);
      }
    }
  }
  contested.insert(contested.end(), differing.begin(), differing.end());
  return clip;
}

}  // namespace fb::bake
