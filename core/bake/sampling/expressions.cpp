#include <algorithm>
#include <cmath>

#include "bake/sampling/pose_generators.h"

namespace fb::bake {

float toward_end(const Control& control, bool up, float share) {
  const float end = up ? control.maximum : control.minimum;
  return std::clamp(control.rest * (1 - share) + end * share, control.minimum, control.maximum);
}

bool draw_end(const Control& control, Random& random) {
  return random.uniform(control.minimum, control.maximum) >= control.rest;
}

namespace {

// How far controls go in one pose: `full` of them to the very end, the others uniform^power of the way. A power above
// one makes small values frequent, below one large ones.
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
      : schema_(schema), probe_(responses), pose_(schema.rest_pose()) {}

  const std::vector<float>& pose() const { return pose_; }

  // Moves `count` controls of a region, drawn without preference. A control that works against one already moved is
  // usually passed over: faces do not pull and push at once, but rigs are asked to now and then.
  void express(const ControlGroup& region, std::size_t count, Strength strength, Random& random) {
    std::vector<std::size_t> order = region.controls;
    std::vector<std::pair<std::size_t, bool>> moved;
    for (std::size_t i = 0; i < order.size() && moved.size() < count; ++i) {
      std::swap(order[i], order[i + random.below(static_cast<std::uint32_t>(order.size() - i))]);
      const std::size_t c = order[i];
      const bool up = draw_end(schema_.controls[c], random);
      const float share = strength.draw(random);
      const bool against = std::any_of(moved.begin(), moved.end(), [&](const auto& other) {
        return probe_.opposed(c, up, other.first, other.second);
      });
      if (against && random.uniform() < 0.75f) continue;
      pose_[c] = toward_end(schema_.controls[c], up, share);
      moved.emplace_back(c, up);
    }
  }

 private:
  const RigSchema& schema_;
  const ControlResponses& probe_;
  std::vector<float> pose_;
};

// `count` different regions, in random order.
std::vector<const ControlGroup*> draw_regions(const std::vector<ControlGroup>& regions, std::size_t count,
                                              Random& random) {
  std::vector<const ControlGroup*> drawn;
  for (const ControlGroup& region : regions) drawn.push_back(&region);
  for (std::size_t i = 0; i < count; ++i)
    std::swap(drawn[i], drawn[i + random.below(static_cast<std::uint32_t>(drawn.size() - i))]);
  drawn.resize(count);
  return drawn;
}

// How many of `total` controls each region gets: by the root of its size, at least one, at most 80 %.
std::vector<std::size_t> share_out(const std::vector<const ControlGroup*>& regions, double total) {
  double sum = 0;
  for (const ControlGroup* region : regions) sum += std::sqrt(static_cast<double>(region->controls.size()));
  std::vector<std::size_t> counts;
  for (const ControlGroup* region : regions) {
    const double size = static_cast<double>(region->controls.size());
    const double most = std::ceil(0.8 * size), wanted = std::round(total * std::sqrt(size) / sum);
    counts.push_back(static_cast<std::size_t>(std::clamp(wanted, 1.0, most)));
  }
  return counts;
}

// `probability` of each control, as a count.
std::size_t draw_count(const ControlGroup& region, float probability, Random& random) {
  return static_cast<std::size_t>(probability * static_cast<float>(region.controls.size()) + random.uniform());
}

const ControlGroup& draw_by_energy(const std::vector<ControlGroup>& regions, Random& random) {
  double u = random.uniform();
  for (const ControlGroup& region : regions) {
    if (u < region.energy) return region;
    u -= region.energy;
  }
  return regions.back();
}

void append(std::vector<float>& all, const std::vector<float>& pose) {
  all.insert(all.end(), pose.begin(), pose.end());
}

}  // namespace

std::vector<float> make_regional(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                 std::size_t poses) {
  std::vector<float> all;
  const std::size_t most_regions = std::min<std::size_t>(4, responses.regions().size());
  for (std::size_t i = 0; i < poses; ++i) {
    Random random = open_stream(seed, Stream::regional, i);
    PoseMaker maker(schema, responses);
    const auto regions =
        draw_regions(responses.regions(), 1 + random.below(static_cast<std::uint32_t>(most_regions)), random);
    const float u = random.uniform();
    const auto counts = share_out(regions, 2 + 36 * u * u);
    const Strength strength = draw_strength(random);
    for (std::size_t r = 0; r < regions.size(); ++r) maker.express(*regions[r], counts[r], strength, random);
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
    const ControlGroup* heaviest = heavy ? &draw_by_energy(responses.regions(), random) : nullptr;
    const float u = random.uniform();
    const float density = heavy ? 0.05f + 0.5f * u * u : 0.05f + 0.85f * u * std::sqrt(u);
    const Strength strength = draw_strength(random);
    for (const ControlGroup& region : responses.regions()) {
      const float here = &region == heaviest ? random.uniform(0.3f, 0.9f) : density * random.uniform(0.0f, 2.0f);
      maker.express(region, draw_count(region, std::min(here, 0.95f), random), strength, random);
    }
    append(all, maker.pose());
  }
  return all;
}

std::vector<float> walk_through(const std::vector<float>& keys, std::size_t width, std::size_t step,
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
  constexpr std::size_t step = 12, walk = 96;
  const std::size_t width = schema.control_count();
  std::vector<float> all;
  for (std::size_t sequence = 0; sequence * walk < poses; ++sequence) {
    Random random = open_stream(seed, Stream::calisthenics, sequence);
    const std::size_t count = std::min<std::size_t>(1 + random.below(2), responses.regions().size());
    std::vector<const ControlGroup*> regions = draw_regions(responses.regions(), count, random);
    regions[0] = &responses.regions()[sequence % responses.regions().size()];
    if (count == 2 && regions[1] == regions[0]) regions.pop_back();
    std::vector<float> keys = schema.rest_pose();
    for (std::size_t key = 0; key < walk / step; ++key) {
      PoseMaker maker(schema, responses);
      const float u = random.uniform();
      const auto counts = share_out(regions, 2 + 18 * u);
      for (std::size_t r = 0; r < regions.size(); ++r)
        maker.express(*regions[r], counts[r], Strength{0.5f, 0.5f}, random);
      append(keys, maker.pose());
    }
    append(all, walk_through(keys, width, step, std::min(walk, poses - sequence * walk)));
  }
  return all;
}

}  // namespace fb::bake
