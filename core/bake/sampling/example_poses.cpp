#include <algorithm>
#include <cmath>
#include <limits>

#include "bake/sampling/mirror_partners.h"
#include "bake/sampling/pose_generators.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_frames = 4000;  // that are selected from, evenly spaced

// Appends frames far from rest and from each other: each time the one whose nearest selected frame is farthest
// (Gonzalez 1985). Distances are between values in units of the controls' reach.
void append_far_frames(std::vector<float>& poses, const RigSchema& schema, std::span<const float> examples,
                       std::size_t count) {
  const std::size_t width = schema.control_count(), all = examples.size() / width;
  const std::size_t stride = (all + most_frames - 1) / most_frames;
  const std::vector<float> rest = schema.rest_pose();
  std::vector<double> nearest((all + stride - 1) / stride, std::numeric_limits<double>::max());
  std::span<const float> last = rest;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t f = 0; f < nearest.size(); ++f) {
      double squares = 0;
      for (std::size_t c = 0; c < width; ++c) {
        const double d = (double(examples[f * stride * width + c]) - last[c]) / schema.controls[c].reach();
        squares += d * d;
      }
      nearest[f] = std::min(nearest[f], squares);
    }
    const auto farthest = std::max_element(nearest.begin(), nearest.end());
    if (*farthest == 0) return;
    last = examples.subspan(static_cast<std::size_t>(farthest - nearest.begin()) * stride * width, width);
    poses.insert(poses.end(), last.begin(), last.end());
  }
}

// Poses like the examples, but none of them.
class ExampleVariations {
 public:
  ExampleVariations(const RigSchema& schema, const ControlResponses& responses, std::span<const float> examples)
      : schema_(schema), responses_(responses), examples_(examples) {
    partners_ =
        mirror_partners(schema, [&](std::size_t a, std::size_t b) { return responses.opposed(a, true, b, true); });
  }

  std::vector<float> pose(Random& random) const {
    std::vector<float> pose = frame(random);
    const float way = random.uniform();
    if (way < 0.3f)
      blend(pose, frame(random), random.uniform(0.25f, 0.75f));
    else if (way < 0.7f)
      exchange_groups(pose, frame(random), random);
    if (random.uniform() < 0.3f) mirror(pose);
    const float amplitude = random.uniform(0.4f, 1.3f), rate = random.uniform(0, 0.3f) * random.uniform();
    for (std::size_t c = 0; c < pose.size(); ++c) {
      const Control& control = schema_.controls[c];
      pose[c] = control.rest + amplitude * (pose[c] - control.rest);
      if (random.uniform() < rate) pose[c] += random.uniform(-0.3f, 0.3f) * control.reach();
      pose[c] = std::clamp(pose[c], control.minimum, control.maximum);
    }
    return pose;
  }

 private:
  std::vector<float> frame(Random& random) const {
    const std::size_t width = schema_.control_count();
    const std::size_t frame = random.below(static_cast<std::uint32_t>(examples_.size() / width));
    const std::span<const float> values = examples_.subspan(frame * width, width);
    return {values.begin(), values.end()};
  }

  static void blend(std::vector<float>& pose, const std::vector<float>& other, float share) {
    for (std::size_t c = 0; c < pose.size(); ++c) pose[c] += share * (other[c] - pose[c]);
  }

  void exchange_groups(std::vector<float>& pose, const std::vector<float>& other, Random& random) const {
    for (const ControlGroup& group : responses_.groups()) {
      if (random.uniform() < 0.5f) continue;
      for (const std::size_t c : group.controls) pose[c] = other[c];
    }
  }

  void mirror(std::vector<float>& pose) const {
    const std::vector<float> before = pose;
    for (std::size_t c = 0; c < pose.size(); ++c) {
      if (!partners_[c]) continue;
      const Control &from = schema_.controls[*partners_[c]], &to = schema_.controls[c];
      const float away = before[*partners_[c]] - from.rest;
      pose[c] = to.rest + away / from.reach() * to.reach();
    }
  }

  const RigSchema& schema_;
  const ControlResponses& responses_;
  const std::span<const float> examples_;
  std::vector<std::optional<std::size_t>> partners_;
};

}  // namespace

std::vector<float> make_like(const RigSchema& schema, const ControlResponses& responses,
                             std::span<const float> examples, std::uint64_t seed, std::size_t poses,
                             std::size_t frames) {
  std::vector<float> all;
  append_far_frames(all, schema, examples, std::min(frames, poses));
  const ExampleVariations variations(schema, responses, examples);
  for (std::size_t i = all.size() / schema.control_count(); i < poses; ++i) {
    Random random = open_stream(seed, Stream::examples, i);
    const std::vector<float> pose = variations.pose(random);
    all.insert(all.end(), pose.begin(), pose.end());
  }
  return all;
}

}  // namespace fb::bake
