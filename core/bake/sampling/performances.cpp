#include <algorithm>
#include <cmath>

#include "bake/sampling/mirror_partners.h"
#include "bake/sampling/pose_generators.h"

namespace fb::bake {
namespace {

// Most controls that expressions move, as a part of all.
constexpr double most_moved = 0.35;

class Performer {
 public:
  Performer(const RigSchema& schema, const ControlResponses& responses) : schema_(schema), probe_(responses) {
    partners_ =
        mirror_partners(schema, [&](std::size_t a, std::size_t b) { return responses.opposed(a, true, b, true); });
    weights_.resize(schema.control_count());
    for (const ControlGroup& region : responses.regions()) {
      double most = 0;
      for (const std::size_t c : region.controls) most = std::max(most, responses.motion(c));
      for (const std::size_t c : region.controls)
        weights_[c] = most > 0 ? static_cast<float>(std::max(0.05, std::sqrt(responses.motion(c) / most))) : 1;
    }
  }

  std::vector<float> pose(Random& random) {
    pose_ = schema_.rest_pose();
    moved_.clear();
    taken_.assign(schema_.control_count(), false);
    const double most = std::max(4.0, most_moved * static_cast<double>(schema_.control_count()));
    const auto wanted = static_cast<std::size_t>(2 * std::pow(most / 2, double(random.uniform())));
    for (int tries = 0; moved_.size() < wanted && tries < 64; ++tries) express(wanted - moved_.size(), random);
    const float rate = random.uniform() * random.uniform();
    for (std::size_t c = 0; c < taken_.size(); ++c) {
      const bool tweaked = random.uniform() < rate;
      const float u = random.uniform();
      const bool up = draw_end(schema_.controls[c], random);
      if (tweaked && !taken_[c]) pose_[c] = toward_end(schema_.controls[c], up, 0.4f * u * u);
    }
    return pose_;
  }

 private:
  const ControlGroup& draw_region(Random& random) const {
    const std::vector<ControlGroup>& regions = probe_.regions();
    const bool even = random.uniform() < 0.4f;
    double u = random.uniform();
    for (const ControlGroup& region : regions) {
      const double part = even ? 1 / static_cast<double>(regions.size()) : region.energy;
      if (u < part) return region;
      u -= part;
    }
    return regions.back();
  }

  std::size_t draw_control(const ControlGroup& region, Random& random) const {
    float sum = 0;
    for (const std::size_t c : region.controls) sum += weights_[c];
    float u = random.uniform() * sum;
    for (const std::size_t c : region.controls)
      if ((u -= weights_[c]) < 0) return c;
    return region.controls.back();
  }

  void move(std::size_t c, bool up, float share, Random& random) {
    if (taken_[c]) return;
    const bool against = std::any_of(moved_.begin(), moved_.end(), [&](const auto& other) {
      return probe_.opposed(c, up, other.first, other.second);
    });
    if (random.uniform() < 0.85f && against) return;
    taken_[c] = true;
    moved_.emplace_back(c, up);
    pose_[c] = toward_end(schema_.controls[c], up, share);
  }

  // A part of an expression: controls of a region that go together, about equally far, most of them on both sides.
  void express(std::size_t most, Random& random) {
    const ControlGroup& region = draw_region(random);
    const float u = random.uniform();
    const auto count = std::min<std::size_t>(
        most, 1 + static_cast<std::size_t>(u * u * 0.7f * static_cast<float>(region.controls.size())));
    const float strength = random.uniform() < 0.3f ? 1 : std::sqrt(random.uniform());
    const float symmetry = random.uniform() < 0.7f ? 1 : random.uniform();
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t c = draw_control(region, random);
      const bool up = draw_end(schema_.controls[c], random);
      const float share = strength * random.uniform(0.6f, 1.0f);
      move(c, up, random.uniform() < 0.3f ? strength : share, random);
      if (!partners_[c]) continue;
      const float other = symmetry * share * (random.uniform() < 0.6f ? 1 : random.uniform(0.6f, 1.0f));
      const Control& partner = schema_.controls[*partners_[c]];
      const bool both_ways = partner.minimum < partner.rest && partner.rest < partner.maximum;
      const bool turned = both_ways && random.uniform() < 0.3f;
      if (other > 0.02f) move(*partners_[c], both_ways ? up != turned : partner.maximum > partner.rest, other, random);
    }
  }

  const RigSchema& schema_;
  const ControlResponses& probe_;
  std::vector<std::optional<std::size_t>> partners_;
  std::vector<float> weights_;  // of each control
  std::vector<float> pose_;
  std::vector<bool> taken_;
  std::vector<std::pair<std::size_t, bool>> moved_;
};

}  // namespace

std::vector<float> make_performances(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                     std::size_t poses) {
  Performer performer(schema, responses);
  std::vector<float> all;
  for (std::size_t i = 0; i < poses; ++i) {
    Random random = open_stream(seed, Stream::performances, i);
    const std::vector<float> pose = performer.pose(random);
    all.insert(all.end(), pose.begin(), pose.end());
  }
  return all;
}

}  // namespace fb::bake
