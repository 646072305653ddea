#include <algorithm>
#include <cmath>

#include "bake/sampling/mirror_partners.h"
#include "bake/sampling/pose_generators.h"

namespace fb::bake {
namespace {

// Share of all controls that the expressions of a pose activate at most.
constexpr double most_active = 0.35;

class PerformancePoses {
 public:
  PerformancePoses(const RigSchema& schema, const ControlResponses& responses)
      : schema_(schema), responses_(responses) {
    partners_ =
        mirror_partners(schema, [&](std::size_t a, std::size_t b) { return responses.opposed(a, true, b, true); });
    weights_.resize(schema.control_count());
    for (const ControlGroup& group : responses.groups()) {
      double most = 0;
      for (const std::size_t c : group.controls) most = std::max(most, responses.motion(c));
      for (const std::size_t c : group.controls)
        weights_[c] = most > 0 ? static_cast<float>(std::max(0.05, std::sqrt(responses.motion(c) / most))) : 1;
    }
  }

  std::vector<float> pose(Random& random) {
    pose_ = schema_.rest_pose();
    active_.clear();
    is_active_.assign(schema_.control_count(), false);
    const double most = std::max(4.0, most_active * static_cast<double>(schema_.control_count()));
    const auto wanted = static_cast<std::size_t>(2 * std::pow(most / 2, double(random.uniform())));
    for (int tries = 0; active_.size() < wanted && tries < 64; ++tries) add_expression(wanted - active_.size(), random);
    const float rate = random.uniform() * random.uniform();
    for (std::size_t c = 0; c < is_active_.size(); ++c) {
      const bool tweaked = random.uniform() < rate;
      const float u = random.uniform();
      const bool up = draw_end(schema_.controls[c], random);
      if (tweaked && !is_active_[c]) pose_[c] = value_toward(schema_.controls[c], up, 0.4f * u * u);
    }
    return pose_;
  }

 private:
  const ControlGroup& draw_group(Random& random) const {
    const std::vector<ControlGroup>& groups = responses_.groups();
    const bool even = random.uniform() < 0.4f;
    double u = random.uniform();
    for (const ControlGroup& group : groups) {
      const double probability = even ? 1 / static_cast<double>(groups.size()) : group.energy;
      if (u < probability) return group;
      u -= probability;
    }
    return groups.back();
  }

  std::size_t draw_control(const ControlGroup& group, Random& random) const {
    float sum = 0;
    for (const std::size_t c : group.controls) sum += weights_[c];
    float u = random.uniform() * sum;
    for (const std::size_t c : group.controls)
      if ((u -= weights_[c]) < 0) return c;
    return group.controls.back();
  }

  void activate(std::size_t c, bool up, float fraction, Random& random) {
    if (is_active_[c]) return;
    const bool opposed = std::any_of(active_.begin(), active_.end(), [&](const auto& other) {
      return responses_.opposed(c, up, other.first, other.second);
    });
    if (random.uniform() < 0.85f && opposed) return;
    is_active_[c] = true;
    active_.emplace_back(c, up);
    pose_[c] = value_toward(schema_.controls[c], up, fraction);
  }

  // Activates controls of one group, about equally far, most of them on both sides of the face.
  void add_expression(std::size_t most, Random& random) {
    const ControlGroup& group = draw_group(random);
    const float u = random.uniform();
    const auto count = std::min<std::size_t>(
        most, 1 + static_cast<std::size_t>(u * u * 0.7f * static_cast<float>(group.controls.size())));
    const float strength = random.uniform() < 0.3f ? 1 : std::sqrt(random.uniform());
    const float symmetry = random.uniform() < 0.7f ? 1 : random.uniform();
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t c = draw_control(group, random);
      const bool up = draw_end(schema_.controls[c], random);
      const float fraction = strength * random.uniform(0.6f, 1.0f);
      activate(c, up, random.uniform() < 0.3f ? strength : fraction, random);
      if (!partners_[c]) continue;
      const float other = symmetry * fraction * (random.uniform() < 0.6f ? 1 : random.uniform(0.6f, 1.0f));
      const Control& partner = schema_.controls[*partners_[c]];
      const bool both_ways = partner.minimum < partner.rest && partner.rest < partner.maximum;
      const bool turned = both_ways && random.uniform() < 0.3f;
      if (other > 0.02f)
        activate(*partners_[c], both_ways ? up != turned : partner.maximum > partner.rest, other, random);
    }
  }

  const RigSchema& schema_;
  const ControlResponses& responses_;
  std::vector<std::optional<std::size_t>> partners_;
  std::vector<float> weights_;  // of each control
  std::vector<float> pose_;
  std::vector<bool> is_active_;
  std::vector<std::pair<std::size_t, bool>> active_;
};

}  // namespace

std::vector<float> make_performances(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                     std::size_t poses) {
  PerformancePoses generator(schema, responses);
  std::vector<float> all;
  for (std::size_t i = 0; i < poses; ++i) {
    Random random = open_stream(seed, Stream::performances, i);
    const std::vector<float> pose = generator.pose(random);
    all.insert(all.end(), pose.begin(), pose.end());
  }
  return all;
}

}  // namespace fb::bake
