#include "bake/analysis/live/difficult_curves.h"

#include <algorithm>
#include <cmath>

#include "bake/analysis/jumping_curve.h"
#include "bake/analysis/live/excitation_curves.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double difficult = 10;  // errors over so many tolerances
constexpr double suspect = 3;     // the same, of a few values only: a curve to sample closely
constexpr double coarse = 5;      // tolerances: cells that bend by twice as much are halved
constexpr int cells = 97;         // of a side, at first: prime, so that jumps at even fractions lie inside cells
constexpr int few_cells = 16;     // of a side, where only jumps are looked for
constexpr int halvings = 2;       // of cells that bend
constexpr int bisections = 60;    // of an interval that may hold a jump
constexpr std::size_t sample_memory = std::size_t{1} << 28, most_samples = 4096;

// The middles of intervals of a continuous curve beside which it bends by more than `most`.
std::vector<double> bent_middles(const CurveSamples& samples, double most) {
  std::vector<double> positions = samples.positions;
  const std::size_t size = samples.displacements[0].size();
  const std::vector<float> zero(size);
  std::vector<const std::vector<float>*> rows;
  for (const std::vector<float>& row : samples.displacements) rows.push_back(&row);
  const auto rest = std::lower_bound(positions.begin(), positions.end(), 0.0) - positions.begin();
  positions.insert(positions.begin() + rest, 0.0);
  rows.insert(rows.begin() + rest, &zero);
  std::vector<bool> bent(positions.size());
  for (std::size_t k = 1; k + 1 < positions.size(); ++k) {
    if (positions[k] == 0) continue;  // curves may have a corner at rest
    const double t = (positions[k] - positions[k - 1]) / (positions[k + 1] - positions[k - 1]);
    for (std::size_t i = 0; i < size && !bent[k]; i += 3) {
      double squares = 0;
      for (std::size_t axis = i; axis < i + 3; ++axis) {
        const double d = (*rows[k])[axis] - (1 - t) * (*rows[k - 1])[axis] - t * (*rows[k + 1])[axis];
        squares += d * d;
      }
      bent[k] = squares > most * most;
    }
  }
  std::vector<double> middles;
  for (std::size_t k = 0; k + 1 < positions.size(); ++k)
    if (bent[k] || bent[k + 1]) middles.push_back((positions[k] + positions[k + 1]) / 2);
  return middles;
}

// Samples one control closely, in a pose of the others, and fits its curve again.
class CurveRefit {
 public:
  CurveRefit(RigEvaluator& rig, const CurveLimits& limits, std::uint32_t index, std::vector<float> pose,
             EvaluationStage& stage)
      : rig_(rig), limits_(limits), control_(rig.schema().controls[index]), pose_(std::move(pose)), stage_(stage) {
    samples_.control = index;
    pose_[index] = control_.rest;
  }

  // Jumps between so many positions of each side; none if the budget does not suffice.
  const std::vector<Jump>& find_jumps_among(int per_side) {
    if (!evaluate(grid(per_side)) || !close_in()) jumps_.clear();
    return jumps_;
  }

  // False, with the samples so far, if the budget or the memory does not suffice.
  bool sample() {
    bool complete = evaluate(grid(cells));
    for (int round = 0; complete && round <= halvings; ++round) {
      complete = close_in();
      if (round == halvings || !complete) break;
      const CurveSamples continuous = without_jumps(samples_, jumps_);
      const std::vector<double> middles = bent_middles(continuous, 2 * coarse * limits_.tolerance);
      if (middles.empty()) break;
      complete = evaluate(middles);
    }
    return complete;
  }

  ControlCurve fit() const { return fit_jumping_curve(control_, samples_, jumps_, limits_); }

  // Largest distance of a curve from the samples, rig units; without those next to a jump that a reader cannot tell
  // from the sample on its other side.
  double error(const ControlCurve& curve) const {
    std::vector<float> pose = rig_.rest_pose();
    double worst = 0;
    for (std::size_t i = 0; i < samples_.positions.size(); ++i) {
      if (is_rounded_away(samples_.positions[i])) continue;
      pose[samples_.control] = value_at(control_, samples_.positions[i]);
      std::vector<float> off = samples_.displacements[i];
      curve.part.add(pose, rig_.rest_pose(), 1, -1, off);
      for (std::size_t k = 0; k < off.size(); k += 3)
        worst = std::max(worst, std::hypot(double(off[k]), off[k + 1], off[k + 2]));
    }
    return worst;
  }

  bool jumps() const { return !jumps_.empty(); }

 private:
  std::vector<double> grid(int per_side) const {
    std::vector<double> positions;
    for (const bool up : {true, false})
      for (int k = 1; k <= per_side && has_side(control_, up); ++k)
        positions.push_back((up ? 1.0 : -1.0) * k / per_side);
    return positions;
  }

  // Adds samples: displacements from the pose with the control at rest.
  bool evaluate(const std::vector<double>& positions) {
    const std::size_t room = std::min(most_samples, sample_memory / (rig_.coordinate_count() * sizeof(float)));
    if (positions.size() > rig_.remaining() / 2 || samples_.positions.size() + positions.size() > room) return false;
    if (at_rest_.empty()) at_rest_ = displacement_at_rest();
    std::vector<std::vector<float>> displacements(positions.size());
    rig_.evaluate_each(
        positions.size(), stage_,
        [&](std::size_t i, std::span<float> pose) {
          std::copy(pose_.begin(), pose_.end(), pose.begin());
          pose[samples_.control] = value_at(control_, positions[i]);
        },
        [&](std::size_t i, std::span<const float>, std::span<float> displacement) {
          displacements[i].assign(displacement.begin(), displacement.end());
          for (std::size_t k = 0; k < displacement.size(); ++k) displacements[i][k] -= at_rest_[k];
        });
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const auto at = std::lower_bound(samples_.positions.begin(), samples_.positions.end(), positions[i]) -
                      samples_.positions.begin();
      samples_.positions.insert(samples_.positions.begin() + at, positions[i]);
      samples_.displacements.insert(samples_.displacements.begin() + at, std::move(displacements[i]));
    }
    return true;
  }

  std::vector<float> displacement_at_rest() {
    std::vector<float> at_rest(rig_.coordinate_count());
    if (pose_ == rig_.rest_pose()) return at_rest;
    rig_.evaluate_each(
        1, stage_, [&](std::size_t, std::span<float> pose) { std::copy(pose_.begin(), pose_.end(), pose.begin()); },
        [&](std::size_t, std::span<const float>, std::span<float> displacement) {
          std::copy(displacement.begin(), displacement.end(), at_rest.begin());
        });
    return at_rest;
  }

  // Bisects what may be jumps; keeps, of the samples that takes, those beside jumps.
  bool close_in() {
    const double least = least_jump * limits_.tolerance;
    const std::vector<double> before = samples_.positions;
    bool complete = true;
    for (int i = 0; i < bisections && complete; ++i) {
      const std::vector<double> middles = positions_to_bisect(control_, samples_, least);
      if (middles.empty()) break;
      complete = evaluate(middles);
    }
    jumps_ = find_jumps(control_, samples_, least);
    CurveSamples kept{samples_.control, {}, {}};
    for (std::size_t i = 0; i < samples_.positions.size(); ++i) {
      const double position = samples_.positions[i];
      if (!std::binary_search(before.begin(), before.end(), position) && !is_beside_jump(position)) continue;
      kept.positions.push_back(position);
      kept.displacements.push_back(std::move(samples_.displacements[i]));
    }
    samples_ = std::move(kept);
    return complete;
  }

  bool is_beside_jump(double position) const {
    return std::any_of(jumps_.begin(), jumps_.end(),
                       [&](const Jump& jump) { return jump.inside == position || jump.outside == position; });
  }

  bool is_rounded_away(double position) const {
    const auto offset = [&](double of) { return (of == 0 ? control_.rest : value_at(control_, of)) - control_.rest; };
    return std::any_of(jumps_.begin(), jumps_.end(), [&](const Jump& jump) {
      return jump.outside == position && offset(jump.inside) == offset(jump.outside);
    });
  }

  RigEvaluator& rig_;
  const CurveLimits& limits_;
  const Control& control_;
  std::vector<float> pose_;
  EvaluationStage& stage_;
  std::vector<float> at_rest_;  // displacement of the pose with the control at rest
  CurveSamples samples_;
  std::vector<Jump> jumps_;
};

}  // namespace

void refit_difficult_curves(RigEvaluator& rig, const AnalysisOptions& options, std::vector<ControlCurve>& curves,
                            std::vector<double>& errors, Progress& progress) {
  const CurveLimits limits = curve_limits(options, rig.diagonal());
  const double acceptable = difficult * limits.tolerance;
  std::vector<std::uint32_t> controls;
  for (std::uint32_t c = 0; c < curves.size(); ++c)
    if (curves[c].steep || curves[c].error > acceptable || errors[c] > suspect * options.curve_tolerance)
      controls.push_back(c);
  if (controls.empty()) return;
  EvaluationStage stage(progress, Phase::analysis, "sampling controls that may jump", controls.size() * 2 * cells);
  std::size_t jumping = 0;
  for (const std::uint32_t c : controls) {
    CurveRefit refit(rig, limits, c, rig.rest_pose(), stage);
    if (!refit.sample()) continue;
    const double first = refit.error(curves[c]);
    if (!refit.jumps() && first <= acceptable) continue;
    ControlCurve curve = refit.fit();
    const double error = refit.error(curve);
    if (curve.part.shapes.empty() || error >= first) continue;
    curve.error = error;
    curves[c] = std::move(curve);
    errors[c] = error / rig.diagonal();
    jumping += refit.jumps();
  }
  progress.note(format("%zu controls were sampled closely; %zu of them jump", controls.size(), jumping));
}

std::vector<Jump> find_jumps_alone(RigEvaluator& rig, std::uint32_t control, double tolerance, EvaluationStage& stage) {
  const CurveLimits limits{tolerance * rig.diagonal(), 0, 0};
  return CurveRefit(rig, limits, control, rig.rest_pose(), stage).find_jumps_among(few_cells);
}

bool add_joint_steps(RigEvaluator& rig, const AnalysisOptions& options, const CorrectiveSearch& correctives,
                     std::vector<ControlCurve>& curves, Progress& progress) {
  const CurveLimits limits = curve_limits(options, rig.diagonal());
  std::vector<CorrectiveSearch::Misfit> misfits = correctives.misfits(difficult * limits.tolerance);
  std::erase_if(misfits, [&](const auto& misfit) { return !curves[misfit.control].steps.empty(); });
  if (misfits.empty()) return false;
  EvaluationStage stage(progress, Phase::analysis, "looking for jumps in company", misfits.size() * few_cells);
  std::size_t jumping = 0;
  for (const auto& [c, pose] : misfits) {
    CurveRefit refit(rig, limits, c, pose, stage);
    const std::vector<Jump>& jumps = refit.find_jumps_among(few_cells);
    if (jumps.empty() || jumps.size() > most_jumps) continue;
    for (const Jump& jump : jumps)
      curves[c].steps.push_back(step(rig.schema().controls[c], c, jump.inside, jump.outside));
    curves[c].knots = plateau_middles(rig.schema().controls[c], jumps);
    curves[c].smooth = false;
    ++jumping;
  }
  if (jumping > 0) progress.note(format("%zu controls jump only together with others", jumping));
  return jumping > 0;
}

}  // namespace fb::bake
