#include "bake/sampling/control_responses.h"

#include <algorithm>
#include <cmath>

#include "bake/analysis/live/difficult_curves.h"
#include "base/vector3.h"

namespace fb::bake {
namespace {

// Evenly spaced vertices that directions are compared at: so few fit in memory for every control.
constexpr std::size_t most_vertices = 1000;

// Directions with a cosine below this are opposed.
constexpr double opposition = -0.5;

// Jumps by more than five times this, over the diagonal, are looked for, where a change between two poses is so many
// times that of its neighbours.
constexpr double jump_tolerance = 2e-4, steep = 3;

// Displacement of evenly spaced vertices, scaled to length 1; empty if they do not move.
std::vector<float> direction(const std::vector<float>& rest, const float* points) {
  const std::size_t vertices = rest.size() / 3, stride = (vertices + most_vertices - 1) / most_vertices;
  std::vector<float> direction;
  double squares = 0;
  for (std::size_t v = 0; v < vertices; v += stride)
    for (std::size_t i = 3 * v; i < 3 * v + 3; ++i) {
      direction.push_back(points[i] - rest[i]);
      squares += double(direction.back()) * direction.back();
    }
  if (squares == 0) return {};
  for (float& d : direction) d = static_cast<float>(d / std::sqrt(squares));
  return direction;
}

// Of a budget, for each control: on a rig of 303 controls, two values left as little error as five with 3,000 poses,
// and five would be 40 % of these; with 9,000, hero left an mse of 5.3e-8, 2.0e-7 and 1.7e-7 with five, 6.7e-8, 2.1e-7
// and 2.0e-7 with two.
constexpr std::uint64_t enough_poses = 20;

// Values of each control that a budget allows for.
std::size_t values_within(const RigSchema& schema, std::uint64_t budget) {
  return budget > 0 && budget / enough_poses < schema.control_count() ? 2 : ControlResponses::most_values;
}

// Evenly spaced over the range.
std::vector<float> spaced_values(const Control& control, std::size_t count) {
  std::vector<float> values;
  for (std::size_t k = 0; k < count; ++k) {
    const float t = static_cast<float>(k) / static_cast<float>(count - 1);
    values.push_back(control.minimum * (1 - t) + control.maximum * t);
  }
  return values;
}

std::vector<float> values_but_rest(const Control& control, std::size_t count) {
  std::vector<float> values = spaced_values(control, count);
  std::erase(values, control.rest);
  return values;
}

// Each of `count` controls from `first` on at so many values.
std::vector<float> poses_of(const RigSchema& schema, std::size_t first, std::size_t count, std::size_t values) {
  std::vector<float> controls;
  for (std::size_t c = first; c < first + count; ++c)
    for (const float value : spaced_values(schema.controls[c], values)) {
      std::vector<float> pose = schema.rest_pose();
      pose[c] = value;
      controls.insert(controls.end(), pose.begin(), pose.end());
    }
  return controls;
}

}  // namespace

std::vector<ControlGroup> control_groups(const RigSchema& schema) {
  std::vector<ControlGroup> groups;
  for (std::size_t c = 0; c < schema.control_count(); ++c) {
    const std::string& name = schema.controls[c].group;
    auto group = std::find_if(groups.begin(), groups.end(), [&](const ControlGroup& g) { return g.name == name; });
    if (group == groups.end()) group = groups.insert(group, ControlGroup{name, {}, 0});
    group->controls.push_back(c);
  }
  for (ControlGroup& group : groups) group.energy = 1 / static_cast<double>(groups.size());
  return groups;
}

ControlResponses::ControlResponses(RigEvaluator& rig, std::uint64_t budget, Progress& progress)
    : values_(values_within(rig.schema(), budget)), answered_(rig.schema().control_count()), diagonal_(rig.diagonal()) {
  const PurposeScope purpose(rig, EvaluationPurpose::single_controls);
  const RigSchema& schema = rig.schema();
  const std::size_t width = schema.control_count(), size = rig.coordinate_count(), values = values_;
  const bool budgeted = budget > 0;
  motion_.resize(width);
  bend_.resize(width);
  steep_.resize(width);
  jumps_.resize(width);
  directions_.resize(2 * width);
  progress.begin(Phase::sampling, "evaluating single controls", width);
  const std::size_t most = std::clamp<std::size_t>((std::size_t{64} << 20) / (values * size * sizeof(float)), 1, 16);
  std::vector<float> points;
  for (std::size_t first = 0; first < width; first += most) {
    const std::size_t count = std::min(most, width - first);
    points.resize(count * values * size);
    try {
      rig.evaluate_cached(poses_of(schema, first, count, values), count * values, points);
    } catch (const PoseError& error) {
      fail(error.status(), "control \"%s\" moved alone, value %zu of %zu: %s",
           schema.controls[first + error.pose() / values].name.c_str(), error.pose() % values + 1, values,
           error.reason().c_str());
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (budgeted) answered_[first + i] = values_but_rest(schema.controls[first + i], values);
      measure(rig, first + i, points.data() + i * values * size);
      if (motion_[first + i] == 0)
        progress.note(format("control \"%s\" alone moves nothing", schema.controls[first + i].name.c_str()));
    }
    progress.step(first + count);
  }
  const auto suspects = static_cast<std::uint64_t>(std::count(steep_.begin(), steep_.end(), 1));
  if (suspects > 0 && !budgeted) {
    EvaluationStage stage(progress, Phase::sampling, "looking for jumps", suspects * 32);
    for (std::size_t c = 0; c < width; ++c)
      if (steep_[c]) find_jumps(rig, c, stage);
  }
  find_groups(schema);
  find_opposed();
}

ControlResponses::ControlResponses(const RigSchema& schema, std::uint64_t budget)
    : answered_(schema.control_count()),
      motion_(schema.control_count(), 1),
      bend_(schema.control_count()),
      jumps_(schema.control_count()),
      directions_(2 * schema.control_count()) {
  for (std::size_t c = 0; budget > 0 && c < answered_.size(); ++c)
    answered_[c] = values_but_rest(schema.controls[c], values_within(schema, budget));
  find_groups(schema);
  find_opposed();
}

std::size_t ControlResponses::poses_within(const RigSchema& schema, std::uint64_t budget) {
  std::size_t poses = 0;
  for (const Control& control : schema.controls)
    poses += values_but_rest(control, values_within(schema, budget)).size();
  return poses;
}

void ControlResponses::find_jumps(RigEvaluator& rig, std::size_t control, EvaluationStage& stage) {
  const Control& c = rig.schema().controls[control];
  for (const Jump& jump : find_jumps_alone(rig, static_cast<std::uint32_t>(control), jump_tolerance, stage))
    jumps_[control].push_back({jump.inside == 0 ? c.rest : value_at(c, jump.inside), value_at(c, jump.outside)});
}

void ControlResponses::measure(const Source& rig, std::size_t control, const float* responses) {
  const std::vector<float>& rest = rig.rest().points;
  const std::size_t size = rest.size(), values = values_;
  const auto root_mean = [&](double squares) { return std::sqrt(3 * squares / static_cast<double>(size)) / diagonal_; };
  std::array<double, most_values + 1> changes{};  // between the poses, 0 beyond the ends
  for (std::size_t k = 0; k + 1 < values; ++k)
    for (std::size_t i = 0; i < size; i += 3)
      changes[k + 1] = std::max(changes[k + 1], double(length(vector_at(responses + (k + 1) * size + i, 0) -
                                                              vector_at(responses + k * size + i, 0))));
  for (std::size_t k = 1; k < values && values == most_values; ++k)
    if (changes[k] > std::max(5 * jump_tolerance * diagonal_, steep * std::max(changes[k - 1], changes[k + 1])))
      steep_[control] = 1;
  for (std::size_t k = 0; k < values; ++k) {
    const float* here = responses + k * size;
    double moved = 0, bent = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double d = double(here[i]) - rest[i];
      moved += d * d;
      if (k == 0 || k + 1 == values) continue;
      const double second = double((here - size)[i]) - 2 * double(here[i]) + (here + size)[i];
      bent += second * second;
    }
    motion_[control] = std::max(motion_[control], root_mean(moved));
    if (k > 0 && k + 1 < values) bend_[control][k - 1] = root_mean(bent);
  }
  const Control& c = rig.schema().controls[control];
  for (const bool up : {false, true})
    if ((up ? c.maximum : c.minimum) != c.rest)
      directions_[2 * control + up] = direction(rest, responses + (up ? values - 1 : 0) * size);
}

void ControlResponses::find_groups(const RigSchema& schema) {
  groups_ = control_groups(schema);
  double total = 0;
  for (const double motion : motion_) total += motion * motion;
  if (total == 0) return;
  for (ControlGroup& group : groups_) {
    group.energy = 0;
    for (const std::size_t c : group.controls) group.energy += motion_[c] * motion_[c] / total;
  }
}

void ControlResponses::find_opposed() {
  const std::size_t ends = directions_.size();
  opposed_.assign(ends * ends, 0);
  for (const ControlGroup& group : groups_)
    for (const std::size_t a : group.controls)
      for (const std::size_t b : group.controls) {
        if (b <= a) continue;
        for (std::size_t i = 2 * a; i < 2 * a + 2; ++i)
          for (std::size_t j = 2 * b; j < 2 * b + 2; ++j) {
            const std::vector<float>&x = directions_[i], &y = directions_[j];
            if (x.empty() || y.empty()) continue;
            double cosine = 0;
            for (std::size_t k = 0; k < x.size(); ++k) cosine += double(x[k]) * y[k];
            opposed_[i * ends + j] = opposed_[j * ends + i] = cosine < opposition;
          }
      }
  directions_.clear();
}

}  // namespace fb::bake
