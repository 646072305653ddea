#include <algorithm>
#include <cmath>

#include "bake/sampling/pose_generators.h"

namespace fb::bake {

float value_toward(const Control& control, bool up, float fraction) {
  const float end = up ? control.maximum : control.minimum;
  return std::clamp(control.rest * (1 - fraction) + end * fraction, control.minimum, control.maximum);
}

bool draw_end(const Control& control, Random& random) {
  return random.uniform(control.minimum, control.maximum) >= control.rest;
}

namespace {

// Distribution of the values of one pose, as fractions of the way from rest: 1 with probability `full`, else
// uniform^power. A power above one makes small values frequent, below one large ones.
struct Strength {
  float full, power;

  float draw(Random& random) const {
    const float u = random.uniform();
    if (random.uniform() < full) return 1;
    return power == 2 ? u * u : power == 1 ? u : std::sqrt(u);
  }
};

Strength draw_strength(Random& random) {
  constexpr float powers[] = {0.5f, 1.0f, 2.0f};
  return {0.15f, powers[random.below(3)]};
}

// Sets controls of one pose, which starts at rest.
class PoseMaker {
 public:
  PoseMaker(const RigSchema& schema, const ControlResponses& responses)
      : schema_(schema), responses_(responses), pose_(schema.rest_pose()) {}

  const std::vector<float>& pose() const { return pose_; }

  // Activates `count` controls of a group, drawn with equal probability. A control opposed to one that is active is
  // skipped three times in four: faces rarely pull and push at once.
  void activate(const ControlGroup& group, std::size_t count, Strength strength, Random& random) {
    std::vector<std::size_t> order = group.controls;
    std::vector<std::pair<std::size_t, bool>> active;  // control, up
    for (std::size_t i = 0; i < order.size() && active.size() < count; ++i) {
      std::swap(order[i], order[i + random.below(static_cast<std::uint32_t>(order.size() - i))]);
      const std::size_t c = order[i];
      const bool up = draw_end(schema_.controls[c], random);
      const float fraction = strength.draw(random);
      const bool opposed = std::any_of(active.begin(), active.end(), [&](const auto& other) {
        return responses_.opposed(c, up, other.first, other.second);
      });
      if (opposed && random.uniform() < 0.75f) continue;
      pose_[c] = value_toward(schema_.controls[c], up, fraction);
      active.emplace_back(c, up);
    }
  }

 private:
  const RigSchema& schema_;
  const ControlResponses& responses_;
  std::vector<float> pose_;
};

// `count` different groups, in random order.
std::vector<const ControlGroup*> draw_groups(const std::vector<ControlGroup>& groups, std::size_t count,
                                             Random& random) {
  std::vector<const ControlGroup*> drawn;
  for (const ControlGroup& group : groups) drawn.push_back(&group);
  for (std::size_t i = 0; i < count; ++i)
    std::swap(drawn[i], drawn[i + random.below(static_cast<std::uint32_t>(drawn.size() - i))]);
  drawn.resize(count);
  return drawn;
}

// Distributes `total` controls over groups by the root of their size: at least one each, at most 80 % of a group.
std::vector<std::size_t> distribute(const std::vector<const ControlGroup*>& groups, double total) {
  double sum = 0;
  for (const ControlGroup* group : groups) sum += std::sqrt(static_cast<double>(group->controls.size()));
  std::vector<std::size_t> counts;
  for (const ControlGroup* group : groups) {
    const double size = static_cast<double>(group->controls.size());
    const double most = std::ceil(0.8 * size), wanted = std::round(total * std::sqrt(size) / sum);
    counts.push_back(static_cast<std::size_t>(std::clamp(wanted, 1.0, most)));
  }
  return counts;
}

// Number of active controls of a group, `probability` times its size on average.
std::size_t draw_count(const ControlGroup& group, float probability, Random& random) {
  return static_cast<std::size_t>(probability * static_cast<float>(group.controls.size()) + random.uniform());
}

const ControlGroup& draw_by_energy(const std::vector<ControlGroup>& groups, Random& random) {
  double u = random.uniform();
  for (const ControlGroup& group : groups) {
    if (u < group.energy) return group;
    u -= group.energy;
  }
  return groups.back();
}

void append(std::vector<float>& all, const std::vector<float>& pose) {
  all.insert(all.end(), pose.begin(), pose.end());
}

}  // namespace

std::vector<float> make_regional(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                 std::size_t poses) {
  std::vector<float> all;
  const std::size_t most_groups = std::min<std::size_t>(4, responses.groups().size());
  for (std::size_t i = 0; i < poses; ++i) {
    Random random = open_stream(seed, Stream::regional, i);
    PoseMaker maker(schema, responses);
    const auto groups =
        draw_groups(responses.groups(), 1 + random.below(static_cast<std::uint32_t>(most_groups)), random);
    const float u = random.uniform();
    const auto counts = distribute(groups, 2 + 36 * u * u);
    const Strength strength = draw_strength(random);
    for (std::size_t g = 0; g < groups.size(); ++g) maker.activate(*groups[g], counts[g], strength, random);
    append(all, maker.pose());
  }
  return all;
}

std::vector<float> make_dense(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                              std::size_t poses, bool heavy) {
  std::vector<float> all;
  for (std::size_t i = 0; i < poses; ++i) {
    Random random = open_stream(seed, heavy ? Stream::heavy : Stream::dense, i);
    PoseMaker maker(schema, responses);
    const ControlGroup* heaviest = heavy ? &draw_by_energy(responses.groups(), random) : nullptr;
    const float u = random.uniform();
    const float density = heavy ? 0.05f + 0.5f * u * u : 0.05f + 0.85f * u * std::sqrt(u);
    const Strength strength = draw_strength(random);
    for (const ControlGroup& group : responses.groups()) {
      const float probability = &group == heaviest ? random.uniform(0.3f, 0.9f) : density * random.uniform(0.0f, 2.0f);
      maker.activate(group, draw_count(group, std::min(probability, 0.95f), random), strength, random);
    }
    append(all, maker.pose());
  }
  return all;
}

std::vector<float> interpolate_keys(const std::vector<float>& keys, std::size_t width, std::size_t step,
                                    std::size_t frames) {
  std::vector<float> all;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const std::size_t key = (frame + 1) / step;
    if ((key + 1) * width > keys.size()) break;
    const bool last = (key + 2) * width > keys.size();
    const float t = static_cast<float>((frame + 1) % step) / static_cast<float>(step);
    if (last && t > 0) break;
    const float blend = t * t * (3 - 2 * t);
    for (std::size_t c = 0; c < width; ++c) {
      const float from = keys[key * width + c], to = last ? from : keys[(key + 1) * width + c];
      all.push_back(std::clamp(from + (to - from) * blend, std::min(from, to), std::max(from, to)));
    }
  }
  return all;
}

std::vector<float> make_calisthenics(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                     std::size_t poses) {
  constexpr std::size_t step = 12, length = 96;  // frames from key to key, of a sequence
  const std::size_t width = schema.control_count();
  std::vector<float> all;
  for (std::size_t sequence = 0; sequence * length < poses; ++sequence) {
    Random random = open_stream(seed, Stream::calisthenics, sequence);
    const std::size_t count = std::min<std::size_t>(1 + random.below(2), responses.groups().size());
    std::vector<const ControlGroup*> groups = draw_groups(responses.groups(), count, random);
    groups[0] = &responses.groups()[sequence % responses.groups().size()];
    if (count == 2 && groups[1] == groups[0]) groups.pop_back();
    std::vector<float> keys = schema.rest_pose();
    for (std::size_t key = 0; key < length / step; ++key) {
      PoseMaker maker(schema, responses);
      const float u = random.uniform();
      const auto counts = distribute(groups, 2 + 18 * u);
      for (std::size_t g = 0; g < groups.size(); ++g)
        maker.activate(*groups[g], counts[g], Strength{0.5f, 0.5f}, random);
      append(keys, maker.pose());
    }
    append(all, interpolate_keys(keys, width, step, std::min(length, poses - sequence * length)));
  }
  return all;
}

}  // namespace fb::bake
