#include "bake/analysis/live/missed_correctives.h"

#include <algorithm>
#include <cmath>

#include "bake/analysis/activation_curve.h"
#include "bake/analysis/live/pose_reduction.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double bound = 2;  // residuals to look into, over the tolerance
constexpr std::size_t most_rounds = 8, most_barren_rounds = 2;
constexpr std::size_t poses_per_control = 4, most_poses = 512;   // dense ones of a round, and as many sparse ones
constexpr std::size_t poses_per_wave = 8, waves = 4;             // reduced in a round
constexpr std::uint32_t fewest_controls = 2, most_controls = 8;  // of a sparse pose
constexpr float least_motion = 1e-4f;  // over D: vertices by which sparse poses choose their controls

class MissedCorrectives {
 public:
  MissedCorrectives(RigEvaluator& rig, const AnalysisOptions& options, std::span<const float> motion,
                    const SparseBlendshapes& base, CorrectiveSearch& correctives, Progress& progress)
      : rig_(rig),
        options_(options),
        motion_(motion),
        base_(base),
        correctives_(correctives),
        progress_(progress),
        most_order_(options.max_triples >= 4  ? 4
                    : options.max_triples > 0 ? 3
                                              : 2) {}

  void run() {
    std::size_t barren = 0;
    while (rounds_ < most_rounds && barren < most_barren_rounds) {
      const std::vector<std::vector<float>> poses = draw_poses();
      if (rig_.remaining() < poses.size()) break;
      ++rounds_;
      std::vector<BadPose> worst = evaluate(poses);
      left_.clear();
      if (worst.empty()) break;
      const std::vector<BadPose> reduced = reduce_worst(std::move(worst));
      left_ = reduced[0].pose;
      const std::size_t added = add(reduced);
      added_ += added;
      barren += added == 0;
    }
    progress_.note(summary());
  }

 private:
  // A value away from rest: an end of the range, or uniform on one side.
  float draw_value(const Control& control, bool end, Random& random) const {
    const bool up = has_side(control, true) && (!has_side(control, false) || random.below(2) == 0);
    const float position = end ? 1 : random.uniform(0.1f, 1);
    return value_at(control, up ? position : -position);
  }

  std::vector<float> dense_pose(Random random) const {
    std::vector<float> pose = rig_.rest_pose();
    const float density = random.uniform(0.1f, 0.5f), ends = random.uniform();
    for (std::size_t c = 0; c < pose.size(); ++c)
      if (random.uniform() < density) pose[c] = draw_value(rig_.schema().controls[c], random.uniform() < ends, random);
    return pose;
  }

  // Controls of a group, or that move a vertex in common.
  std::vector<float> sparse_pose(Random random) const {
    std::vector<float> pose = rig_.rest_pose();
    const std::vector<Control>& controls = rig_.schema().controls;
    const std::size_t vertices = rig_.coordinate_count() / 3;
    const std::uint32_t first = random.below(std::uint32_t(pose.size()));
    std::vector<std::uint32_t> moved;  // by the first control
    for (std::uint32_t v = 0; v < vertices; ++v)
      if (motion_[first * vertices + v] > least_motion) moved.push_back(v);
    std::vector<std::uint32_t> others;
    const std::size_t vertex = moved.empty() ? 0 : moved[random.below(std::uint32_t(moved.size()))];
    const bool by_group = moved.empty() || random.below(4) == 0;
    for (std::uint32_t c = 0; c < pose.size(); ++c)
      if (c != first &&
          (by_group ? controls[c].group == controls[first].group : motion_[c * vertices + vertex] > least_motion))
        others.push_back(c);
    const std::size_t count = fewest_controls + random.below(most_controls - fewest_controls + 1);
    const float ends = random.uniform();
    pose[first] = draw_value(controls[first], random.uniform() < ends, random);
    for (std::size_t k = 1; k < count && !others.empty(); ++k) {
      const auto picked = others.begin() + random.below(std::uint32_t(others.size()));
      pose[*picked] = draw_value(controls[*picked], random.uniform() < ends, random);
      others.erase(picked);
    }
    return pose;
  }

  std::vector<std::vector<float>> draw_poses() const {
    const std::size_t count = std::min(poses_per_control * rig_.rest_pose().size(), most_poses);
    std::vector<std::vector<float>> poses;
    for (std::size_t i = 0; i < 2 * count; ++i) {
      const Random random = open_stream(options_.seed, Stream::missed_correctives, 2 * most_poses * rounds_ + i);
      poses.push_back(i < count ? dense_pose(random) : sparse_pose(random));
    }
    return poses;
  }

  double residual_at(std::span<const float> pose, std::uint32_t vertex, std::span<float> displacement) const {
    base_.add(pose, rig_.rest_pose(), 1, -1, displacement);
    return std::hypot(double(displacement[3 * vertex]), displacement[3 * vertex + 1], displacement[3 * vertex + 2]);
  }

  // Those of the poses that are off by more than the bound, the worst first.
  std::vector<BadPose> evaluate(const std::vector<std::vector<float>>& poses) {
    std::vector<BadPose> evaluated(poses.size());
    EvaluationStage stage(progress_, Phase::analysis, "looking for missed correctives", poses.size());
    rig_.evaluate_each(
        poses.size(), stage,
        [&](std::size_t i, std::span<float> pose) { std::copy(poses[i].begin(), poses[i].end(), pose.begin()); },
        [&](std::size_t i, std::span<const float> pose, std::span<float> displacement) {
          base_.add(pose, rig_.rest_pose(), 1, -1, displacement);
          evaluated[i].pose = poses[i];
          for (std::uint32_t v = 0; v < displacement.size() / 3; ++v) {
            const double distance =
                std::hypot(double(displacement[3 * v]), displacement[3 * v + 1], displacement[3 * v + 2]);
            if (distance <= evaluated[i].residual) continue;
            evaluated[i].residual = distance;
            evaluated[i].vertex = v;
          }
        });
    largest_ = 0;
    for (const BadPose& pose : evaluated) largest_ = std::max(largest_, pose.residual);
    std::erase_if(evaluated, [&](const BadPose& pose) {
      return pose.residual <= bound * options_.corrective_tolerance * rig_.diagonal();
    });
    std::stable_sort(evaluated.begin(), evaluated.end(),
                     [](const BadPose& a, const BadPose& b) { return a.residual > b.residual; });
    return evaluated;
  }

  bool contains(const BadPose& pose, std::span<const std::uint32_t> controls) const {
    return std::all_of(controls.begin(), controls.end(),
                       [&](std::uint32_t c) { return pose.pose[c] != rig_.rest_pose()[c]; });
  }

  // Reduces the worst poses, several at once at different vertices; then those without the controls found by then.
  std::vector<BadPose> reduce_worst(std::vector<BadPose> worst) {
    std::stable_partition(worst.begin() + 1, worst.end(), [&](const BadPose& pose) {
      return std::none_of(futile_.begin(), futile_.end(),
                          [&](const auto& controls) { return contains(pose, controls); });
    });
    std::vector<BadPose> reduced;
    for (std::size_t wave = 0; wave < waves && !worst.empty(); ++wave) {
      std::vector<BadPose> chosen, others;
      for (BadPose& pose : worst) {
        const bool taken = std::any_of(chosen.begin(), chosen.end(),
                                       [&](const BadPose& other) { return other.vertex == pose.vertex; });
        (taken || chosen.size() == poses_per_wave ? others : chosen).push_back(std::move(pose));
      }
      reduce(chosen);
      for (BadPose& pose : chosen) {
        const std::vector<std::uint32_t> controls = active_controls(pose.pose, rig_.rest_pose());
        if (pose.reduced) std::erase_if(others, [&](const BadPose& other) { return contains(other, controls); });
        reduced.push_back(std::move(pose));
      }
      worst = std::move(others);
    }
    return reduced;
  }

  void reduce(std::vector<BadPose>& poses) {
    const std::size_t vertices = rig_.coordinate_count() / 3;
    std::vector<PoseReduction> reductions;
    std::uint64_t total = 0;
    for (BadPose& pose : poses) {
      std::vector<std::uint32_t> order = active_controls(pose.pose, rig_.rest_pose());
      std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return motion_[a * vertices + pose.vertex] < motion_[b * vertices + pose.vertex];
      });
      total += order.size();
      reductions.emplace_back(pose, std::move(order), rig_.rest_pose());
    }
    EvaluationStage stage(progress_, Phase::analysis, "reducing poses with missed correctives", total);
    for (;;) {
      std::vector<PoseReduction*> open;
      for (PoseReduction& reduction : reductions)
        if (!reduction.done()) open.push_back(&reduction);
      if (open.empty() || rig_.remaining() < open.size()) break;
      std::vector<double> residuals(open.size());
      rig_.evaluate_each(
          open.size(), stage, [&](std::size_t i, std::span<float> pose) { open[i]->fill(pose); },
          [&](std::size_t i, std::span<const float> pose, std::span<float> displacement) {
            residuals[i] = residual_at(pose, open[i]->vertex(), displacement);
          });
      for (std::size_t i = 0; i < open.size(); ++i) open[i]->advance(residuals[i]);
    }
    for (std::size_t i = 0; i < poses.size(); ++i) poses[i].reduced = reductions[i].done();
  }

  // Adds correctives of the controls that have none. Others, and those that cannot be fitted, are reduced last from
  // now on. Returns how many were added.
  std::size_t add(std::span<const BadPose> reduced) {
    std::vector<std::vector<std::uint32_t>> missed;
    const auto listed = [](const std::vector<std::vector<std::uint32_t>>& list,
                           const std::vector<std::uint32_t>& controls) {
      return std::find(list.begin(), list.end(), controls) != list.end();
    };
    for (const BadPose& pose : reduced) {
      if (!pose.reduced) continue;
      const std::vector<std::uint32_t> controls = active_controls(pose.pose, rig_.rest_pose());
      if (listed(futile_, controls) || listed(missed, controls)) continue;
      const bool is_missed = controls.size() >= 2 && controls.size() <= most_order_ && !correctives_.has(controls);
      (is_missed ? missed : futile_).push_back(controls);
    }
    const std::size_t added = correctives_.add(missed);
    for (const std::vector<std::uint32_t>& controls : missed)
      if (!correctives_.has(controls)) futile_.push_back(controls);
    return added;
  }

  std::string summary() const {
    if (rounds_ == 0) return "the budget of rig calls leaves too few to look for missed correctives";
    const std::string left =
        format("%zu missed correctives added; round %zu of fresh poses left %s%.1e of the diagonal", added_, rounds_,
               left_.empty() ? "at most " : "", largest_ / rig_.diagonal());
    if (left_.empty()) return left;
    return left + ", half of it or more with " + describe_pose(rig_.schema(), left_);
  }

  RigEvaluator& rig_;
  const AnalysisOptions& options_;
  const std::span<const float> motion_;
  const SparseBlendshapes& base_;
  CorrectiveSearch& correctives_;
  Progress& progress_;
  const std::size_t most_order_;
  std::vector<std::vector<std::uint32_t>> futile_;  // controls that leave a residual which no further corrective holds
  std::size_t rounds_ = 0, added_ = 0;
  double largest_ = 0;       // residual of the last round, rig units
  std::vector<float> left_;  // the pose it reduces to; empty if it is within the bound
};

}  // namespace

void add_missed_correctives(RigEvaluator& rig, const AnalysisOptions& options, std::span<const float> motion,
                            const SparseBlendshapes& base, std::uint64_t most_calls, CorrectiveSearch& correctives,
                            Progress& progress) {
  // Without a limit, remaining() / 4 is more than any number of calls.
  const EvaluationBudget share(rig, std::max<std::uint64_t>(std::min(most_calls, rig.remaining() / 4), 1));
  MissedCorrectives(rig, options, motion, base, correctives, progress).run();
}

}  // namespace fb::bake
