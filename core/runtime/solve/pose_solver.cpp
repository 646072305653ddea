#include "runtime/solve/pose_solver.h"

#include <algorithm>
#include <cmath>

namespace fb::runtime {
namespace {

constexpr std::size_t motion_unknowns = SolveResiduals::motion_unknowns;
constexpr unsigned most_steps = 6;  // of one linearisation
constexpr float least_damping = 1e-3f, most_damping = 1e4f;
// Without any preference a control that moves nothing would have no solution.
constexpr float least_nearness = 1e-4f;

float diagonal_preference(const SolvePreferences& preferences) {
  return std::max(preferences.nearness, least_nearness) + (preferences.before ? preferences.smoothness : 0);
}

}  // namespace

PoseSolver::PoseSolver(const Evaluator& evaluator, const Followed& followed, std::span<const PointPair> pairs,
                       std::pmr::memory_resource& memory)
    : schema_(evaluator.schema()),
      residuals_(evaluator, followed, pairs, memory),
      box_(evaluator.control_count() + motion_unknowns, evaluator.kernels(), memory),
      mirrors_(evaluator.control_count(), &memory),
      lower_(evaluator.control_count(), &memory),
      upper_(evaluator.control_count(), &memory),
      places_(evaluator.control_count(), &memory),
      tried_(evaluator.control_count(), &memory),
      near_(evaluator.control_count(), &memory),
      before_(evaluator.control_count(), &memory),
      gradient_(evaluator.control_count() + motion_unknowns, &memory),
      unknowns_(&memory),
      unknown_of_(evaluator.control_count(), &memory),
      downwards_(evaluator.control_count(), &memory),
      below_(evaluator.control_count(), &memory),
      held_(evaluator.control_count(), &memory),
      controls_(evaluator.control_count(), &memory) {
  unknowns_.reserve(gradient_.size());
  for (std::uint32_t c = 0; c < mirrors_.size(); ++c) {
    const Control& control = schema_.controls[c];
    mirrors_[c] = c;
    if (!control.labels.mirror.empty())
      for (std::uint32_t other = 0; other < mirrors_.size(); ++other)
        if (schema_.controls[other].name == control.labels.mirror) mirrors_[c] = other;
    lower_[c] = place(c, control.minimum);
    upper_[c] = place(c, control.maximum);
  }
}

float PoseSolver::place(std::size_t control, float value) const {
  const Control& of = schema_.controls[control];
  return (value - of.rest) / (of.maximum - of.minimum);
}

void PoseSolver::set_controls(const float* places, float* controls) const {
  for (std::size_t c = 0; c < places_.size(); ++c) {
    const Control& of = schema_.controls[c];
    const float value = of.rest + places[c] * (of.maximum - of.minimum);
    controls[c] = places[c] <= lower_[c]   ? of.minimum
                  : places[c] >= upper_[c] ? of.maximum
                                           : std::min(std::max(value, of.minimum), of.maximum);
  }
}

double PoseSolver::preference_cost(const SolvePreferences& preferences, const float* places) const {
  const float nearness = std::max(preferences.nearness, least_nearness);
  double sum = 0;
  for (std::size_t c = 0; c < places_.size(); ++c) {
    const double from_near = places[c] - near_[c], from_before = places[c] - before_[c];
    sum += 0.5 * nearness * from_near * from_near + preferences.sparsity * std::fabs(places[c]);
    if (preferences.before) sum += 0.5 * preferences.smoothness * from_before * from_before;
    const double from_mirror = mirrors_[c] > c ? places[c] - places[mirrors_[c]] : 0;
    sum += 0.5 * preferences.symmetry * from_mirror * from_mirror;
  }
  return sum;
}

// All but sparsity's.
void PoseSolver::find_gradient(const SolvePreferences& preferences) {
  std::fill(gradient_.begin(), gradient_.end(), 0.0f);
  residuals_.add_gradient(preferences.find_motion, gradient_.data());
  const float nearness = std::max(preferences.nearness, least_nearness);
  for (std::size_t c = 0; c < places_.size(); ++c) {
    gradient_[c] += nearness * (places_[c] - near_[c]);
    if (preferences.before) gradient_[c] += preferences.smoothness * (places_[c] - before_[c]);
    gradient_[c] += preferences.symmetry * (places_[c] - places_[mirrors_[c]]);
  }
}

// The unknowns that the gradient does not hold. A control that can move to both sides of rest moves on one of them at a
// time, as poses, and sparsity, bend there: one that rests there and is held tries the other side next.
void PoseSolver::choose_unknowns(const SolvePreferences& preferences) {
  unknowns_.clear();
  other_sides_ = false;
  for (std::uint32_t c = 0; c < places_.size(); ++c) {
    unknown_of_[c] = UINT32_MAX;
    if (preferences.movable && !preferences.movable[c]) continue;
    const float at = places_[c];
    const bool two_sided = lower_[c] < 0 && upper_[c] > 0;
    below_[c] = at < 0 || (at == 0 && (two_sided ? downwards_[c] != 0 : upper_[c] == 0));
    const float slope = gradient_[c] + (below_[c] ? -preferences.sparsity : preferences.sparsity);
    if ((at <= (below_[c] ? lower_[c] : 0) && slope >= 0) || (at >= (below_[c] ? 0 : upper_[c]) && slope <= 0)) {
      if (two_sided && at == 0) {
        downwards_[c] = !below_[c];
        other_sides_ = true;
      }
      continue;
    }
    unknown_of_[c] = static_cast<std::uint32_t>(unknowns_.size());
    unknowns_.push_back(c);
  }
  for (std::uint32_t m = 0; m < motion_unknowns && preferences.find_motion; ++m)
    unknowns_.push_back(static_cast<std::uint32_t>(places_.size()) + m);
}

// Gradient and bounds of the unknowns.
void PoseSolver::set_box(const SolvePreferences& preferences) {
  for (std::size_t i = 0; i < unknowns_.size(); ++i) {
    const std::uint32_t c = unknowns_[i];
    box_.gradient()[i] = gradient_[c];
    if (c >= places_.size()) {
      box_.lower()[i] = -1e30f;
      box_.upper()[i] = 1e30f;
      continue;
    }
    box_.gradient()[i] += below_[c] ? -preferences.sparsity : preferences.sparsity;
    box_.lower()[i] = (below_[c] ? lower_[c] : 0) - places_[c];
    box_.upper()[i] = (below_[c] ? 0 : upper_[c]) - places_[c];
  }
}

void PoseSolver::add_preference_products(const SolvePreferences& preferences) {
  const float diagonal = diagonal_preference(preferences);
  const std::size_t stride = box_.row_stride();
  for (std::size_t i = 0; i < unknowns_.size() && unknowns_[i] < places_.size(); ++i) {
    const std::uint32_t mirror = mirrors_[unknowns_[i]];
    float* const row = box_.matrix() + i * stride;
    row[i] += diagonal;
    if (mirror == unknowns_[i] || preferences.symmetry == 0) continue;
    row[i] += preferences.symmetry;
    const std::uint32_t j = unknown_of_[mirror];
    if (j < i) row[j] -= preferences.symmetry;
  }
}

// tried_ and tried_motion_: where the step leads.
void PoseSolver::take_step(const SolvePreferences& preferences, const RigidMotion& motion) {
  std::copy(places_.begin(), places_.end(), tried_.begin());
  const float* const step = box_.step();
  std::size_t i = 0;
  for (; i < unknowns_.size() && unknowns_[i] < places_.size(); ++i) {
    const std::uint32_t c = unknowns_[i];
    const float to = places_[c] + step[i];
    const bool to_rest =
        (step[i] == box_.lower()[i] && places_[c] > 0) || (step[i] == box_.upper()[i] && places_[c] < 0);
    tried_[c] = to_rest && lower_[c] <= 0 && upper_[c] >= 0 ? 0 : std::min(std::max(to, lower_[c]), upper_[c]);
  }
  tried_motion_ = motion;
  if (!preferences.find_motion) return;
  tried_motion_ = motion.after({step[i], step[i + 1], step[i + 2]}, {step[i + 3], step[i + 4], step[i + 5]});
}

void PoseSolver::linearise(const SolvePreferences& preferences) {
  find_gradient(preferences);
  choose_unknowns(preferences);
  for (std::size_t i = 0; i < unknowns_.size(); ++i) std::fill_n(box_.matrix() + i * box_.row_stride(), i + 1, 0.0f);
  residuals_.add_products(unknowns_, box_.matrix(), box_.row_stride());
  add_preference_products(preferences);
  box_.set_matrix(unknowns_.size(), damping_);
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    box_.held()[i] = unknowns_[i] < places_.size() ? held_[unknowns_[i]] : BoxMinimum::Held::free;
}

// A step of the linearisation there is, with as much damping as it takes to lower the objective. False where none does.
bool PoseSolver::advance(const SolvePreferences& preferences, double& objective, RigidMotion& motion) {
  for (; damping_ < most_damping; box_.set_matrix(unknowns_.size(), damping_)) {
    const float more = std::max(8 * damping_, least_damping);
    set_box(preferences);
    if (!box_.solve()) {
      damping_ = more;
      continue;
    }
    const double expected = box_.decrease();
    if (!(expected > 1e-9 * objective)) return false;
    take_step(preferences, motion);
    residuals_.set_motion(tried_motion_);
    set_controls(tried_.data(), controls_.data());
    const double after = residuals_.find(controls_.data()) + preference_cost(preferences, tried_.data());
    if (!(after < objective)) {
      damping_ = more;
      continue;
    }
    std::swap(places_, tried_);
    motion = tried_motion_;
    const double gain = (objective - after) / expected;
    const float before = damping_;
    damping_ = gain > 0.75 ? damping_ / 8 : gain < 0.25 ? more : damping_;
    if (damping_ < least_damping) damping_ = 0;
    if (damping_ != before) box_.set_matrix(unknowns_.size(), damping_);
    objective = after;
    return true;
  }
  damping_ = 0;
  return false;
}

// Steps of one linearisation: with the derivatives there are, further ones cost little. Returns whether another
// linearisation may lower the objective.
bool PoseSolver::step(const SolvePreferences& preferences, SolveResult& result, RigidMotion& motion) {
  set_controls(places_.data(), controls_.data());
  const double before =
      residuals_.run(controls_.data(), downwards_.data()) + preference_cost(preferences, places_.data());
  double objective = before;
  ++result.iterations;
  linearise(preferences);
  for (unsigned steps = 0; steps < most_steps && !unknowns_.empty(); ++steps) {
    const double last = objective;
    if (steps > 0) find_gradient(preferences);
    if (!advance(preferences, objective, motion)) {
      residuals_.set_motion(motion);
      break;
    }
    if (last - objective < 0.02 * last) break;
  }
  for (std::size_t i = 0; i < unknowns_.size() && unknowns_[i] < places_.size(); ++i)
    held_[unknowns_[i]] = box_.held()[i];
  result.objective = objective;
  return before - objective > preferences.tolerance * before;
}

SolveResult PoseSolver::solve(const SolveTargets& targets, const SolvePreferences& preferences, float* controls,
                              RigidMotion& motion) {
  residuals_.set_targets(targets, preferences.noise);
  residuals_.set_motion(motion);
  for (std::size_t c = 0; c < places_.size(); ++c) {
    const auto place_of = [&](const float* values) {
      return std::min(std::max(place(c, values[c]), lower_[c]), upper_[c]);
    };
    places_[c] = place_of(controls);
    near_[c] = preferences.near ? place_of(preferences.near) : 0;
    before_[c] = preferences.before ? place_of(preferences.before) : 0;
  }
  damping_ = 0;
  SolveResult result;
  std::fill(downwards_.begin(), downwards_.end(), std::uint8_t(0));
  for (int idle = 0; result.iterations < preferences.most_iterations && !result.converged;) {
    idle = step(preferences, result, motion) ? 0 : idle + 1;
    result.converged = idle == (other_sides_ ? 2 : 1);  // both sides of controls at rest were tried
  }
  set_controls(places_.data(), controls);
  residuals_.find(controls);
  return result;
}

void PoseSolver::find_decided(const SolvePreferences& preferences, float* decided) {
  set_controls(places_.data(), controls_.data());
  residuals_.run(controls_.data(), downwards_.data());
  SolvePreferences plain = preferences;
  plain.sparsity = 0;
  if (diagonal_preference(plain) <= least_nearness) plain.nearness = 1;
  const std::size_t controls = places_.size();
  unknowns_.clear();
  for (std::uint32_t c = 0; c < controls; ++c) {
    decided[c] = 0;
    unknown_of_[c] = UINT32_MAX;
    if (plain.movable && !plain.movable[c]) continue;
    unknown_of_[c] = static_cast<std::uint32_t>(unknowns_.size());
    unknowns_.push_back(c);
  }
  for (std::uint32_t m = 0; m < motion_unknowns && plain.find_motion; ++m)
    unknowns_.push_back(static_cast<std::uint32_t>(controls) + m);
  for (std::size_t i = 0; i < unknowns_.size(); ++i) std::fill_n(box_.matrix() + i * box_.row_stride(), i + 1, 0.0f);
  residuals_.add_products(unknowns_, box_.matrix(), box_.row_stride());
  add_preference_products(plain);
  box_.set_matrix(unknowns_.size(), 0);
  if (!box_.find_variances()) return;
  const float preference = diagonal_preference(plain);
  for (std::size_t i = 0; i < unknowns_.size() && unknowns_[i] < controls; ++i)
    decided[unknowns_[i]] = std::min(std::max(1.0f - preference * box_.step()[i], 0.0f), 1.0f);
}

}  // namespace fb::runtime
