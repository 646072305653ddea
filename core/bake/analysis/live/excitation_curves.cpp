#include "bake/analysis/live/excitation_curves.h"

#include <algorithm>
#include <cmath>

#include "bake/analysis/blendshape_parts.h"
#include "bake/analysis/curve_jumps.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Controls whose samples, at most 24 a side, are in memory together; fewer of large faces, so that a common number of
// samples each takes so many bytes.
constexpr std::size_t most_controls_at_once = 24, common_samples = 32, sample_bytes = std::size_t{1} << 28;
constexpr int refinement_rounds = 5;
constexpr int initial_samples = 8;   // of a side
constexpr int validation_draws = 3;  // of a side
constexpr std::size_t most_knot_positions = 4, most_jumping_positions = 8;

// One control away from rest.
struct ControlPosition {
  std::size_t control;
  double position;
};

void insert(CurveSamples& samples, double position, std::vector<float> displacement) {
  const auto at =
      std::lower_bound(samples.positions.begin(), samples.positions.end(), position) - samples.positions.begin();
  samples.positions.insert(samples.positions.begin() + at, position);
  samples.displacements.insert(samples.displacements.begin() + at, std::move(displacement));
}

// `per_side` evenly spaced positions on both sides of controls [begin, end).
std::vector<ControlPosition> even_positions(const RigSchema& schema, std::size_t begin, std::size_t end, int per_side) {
  std::vector<ControlPosition> positions;
  for (std::size_t c = begin; c < end; ++c)
    for (const bool up : {true, false})
      for (int k = 1; k <= per_side && has_side(schema.controls[c], up); ++k)
        positions.push_back({c, (up ? 1.0 : -1.0) * k / per_side});
  return positions;
}

// Evaluates the rig at these positions and calls use(i, rig minus curve) for each.
template <class Use>
void evaluate_curve_errors(RigEvaluator& rig, const std::vector<ControlCurve>& curves,
                           const std::vector<ControlPosition>& positions, EvaluationStage& stage, const Use& use) {
  rig.evaluate_each(
      positions.size(), stage,
      [&](std::size_t i, std::span<float> pose) {
        pose[positions[i].control] = value_at(rig.schema().controls[positions[i].control], positions[i].position);
      },
      [&](std::size_t i, std::span<const float> pose, std::span<float> displacement) {
        curves[positions[i].control].part.add(pose, rig.rest_pose(), 1, -1, displacement);
        use(i, std::span<const float>(displacement));
      });
}

// Raises the motion of one control, a number a vertex, to the distances of its samples over D.
void raise_motion(std::span<float> motion, const CurveSamples& samples, double diagonal) {
  for (const std::vector<float>& d : samples.displacements)
    for (std::size_t v = 0; v < motion.size(); ++v) {
      const double squares =
          double(d[3 * v]) * d[3 * v] + double(d[3 * v + 1]) * d[3 * v + 1] + double(d[3 * v + 2]) * d[3 * v + 2];
      motion[v] = std::max(motion[v], static_cast<float>(std::sqrt(squares) / diagonal));
    }
}

// Samples some consecutive controls, [begin, end).
class ControlSampler {
 public:
  ControlSampler(RigEvaluator& rig, const CurveLimits& limits, std::size_t begin, std::size_t end, Progress& progress)
      : rig_(rig), limits_(limits), begin_(begin), end_(end), progress_(progress), samples_(end - begin) {
    for (std::size_t c = begin; c < end; ++c) samples_[c - begin].control = static_cast<std::uint32_t>(c);
  }

  // `reserved`: poses of the budget that are left to later controls.
  std::vector<CurveSamples> sample(int per_side, std::uint64_t reserved) {
    evaluate(even_positions(rig_.schema(), begin_, end_, per_side), reserved);
    for (int round = 0; round < refinement_rounds; ++round)
      if (!evaluate(refined_positions(), reserved)) break;
    return std::move(samples_);
  }

 private:
  std::vector<ControlPosition> refined_positions() const {
    std::vector<std::vector<double>> bent(samples_.size());
    parallel_for(rig_.parallel(), bent.size(), [&](std::size_t i, std::size_t) {
      if (!samples_[i].positions.empty()) bent[i] = positions_to_refine(samples_[i], limits_);
    });
    std::vector<ControlPosition> positions;
    for (std::size_t i = 0; i < bent.size(); ++i)
      for (const double position : bent[i]) positions.push_back({begin_ + i, position});
    return positions;
  }

  // Adds as many samples as the budget allows; false if that is none.
  bool evaluate(std::vector<ControlPosition> positions, std::uint64_t reserved) {
    const RigSchema& schema = rig_.schema();
    const std::uint64_t available = rig_.remaining() > reserved ? rig_.remaining() - reserved : 0;
    if (positions.size() > available) positions.resize(available);
    if (positions.empty()) return false;
    std::vector<std::vector<float>> displacements(positions.size());
    EvaluationStage stage(progress_, Phase::analysis,
                          format("evaluating controls %zu to %zu of %zu", begin_ + 1, end_, schema.control_count()),
                          positions.size());
    rig_.evaluate_each(
        positions.size(), stage,
        [&](std::size_t i, std::span<float> pose) {
          pose[positions[i].control] = value_at(schema.controls[positions[i].control], positions[i].position);
        },
        [&](std::size_t i, std::span<const float>, std::span<float> displacement) {
          displacements[i].assign(displacement.begin(), displacement.end());
        });
    for (std::size_t i = 0; i < positions.size(); ++i)
      insert(samples_[positions[i].control - begin_], positions[i].position, std::move(displacements[i]));
    return true;
  }

  RigEvaluator& rig_;
  const CurveLimits& limits_;
  std::size_t begin_, end_;
  Progress& progress_;
  std::vector<CurveSamples> samples_;
};

}  // namespace

CurveLimits curve_limits(const AnalysisOptions& options, double diagonal) {
  return {options.curve_tolerance * diagonal, 1e-6 * diagonal, options.max_knots};
}

std::vector<ControlCurve> fit_excitations(RigEvaluator& rig, const AnalysisOptions& options, std::vector<float>& motion,
                                          Progress& progress) {
  const RigSchema& schema = rig.schema();
  const std::size_t width = schema.control_count(), vertices = rig.coordinate_count() / 3;
  const CurveLimits limits = curve_limits(options, rig.diagonal());
  motion.assign(width * vertices, 0);
  std::vector<ControlCurve> curves(width);
  int per_side = initial_samples;
  while (per_side > 1 && even_positions(schema, 0, width, per_side).size() > rig.remaining() / 2) per_side /= 2;
  if (per_side < initial_samples)
    progress.note(format("the budget of rig calls allows for %d of %d initial samples on each side of a control",
                         per_side, initial_samples));
  const std::size_t controls_at_once = std::clamp<std::size_t>(
      sample_bytes / (common_samples * sizeof(float) * rig.coordinate_count()), 2, most_controls_at_once);
  for (std::size_t begin = 0; begin < width; begin += controls_at_once) {
    const std::size_t end = std::min(width, begin + controls_at_once);
    const std::size_t reserved = even_positions(schema, end, width, per_side).size();
    const std::vector<CurveSamples> samples =
        ControlSampler(rig, limits, begin, end, progress).sample(per_side, reserved);
    parallel_for(rig.parallel(), end - begin, [&](std::size_t i, std::size_t) {
      if (samples[i].positions.empty()) return;
      const Control& control = schema.controls[begin + i];
      curves[begin + i] = fit_curve(control, samples[i], limits);
      curves[begin + i].steep = !positions_to_bisect(control, samples[i], least_jump * limits.tolerance).empty();
      raise_motion(std::span(motion).subspan((begin + i) * vertices, vertices), samples[i], rig.diagonal());
    });
  }
  return curves;
}

std::vector<double> knot_positions(const Control& control, const ControlCurve& curve) {
  std::vector<double> positions;
  for (const bool up : {true, false})
    if (has_side(control, up)) positions.push_back(up ? 1 : -1);
  const std::size_t most = curve.steps.empty() ? most_knot_positions : most_jumping_positions;
  const auto add = [&](double position) {
    if (positions.size() < most && has_side(control, position > 0) &&
        std::find(positions.begin(), positions.end(), position) == positions.end())
      positions.push_back(position);
  };
  for (const double knot : curve.knots) add(knot);
  for (const double position : {0.5, -0.5, 0.25, 0.75, -0.75}) add(position);
  return positions;
}

std::vector<CurveErrors> measure_curves(RigEvaluator& rig, const std::vector<ControlCurve>& curves,
                                        Progress& progress) {
  const RigSchema& schema = rig.schema();
  std::vector<CurveErrors> errors(curves.size());
  std::vector<ControlPosition> all;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    errors[c].positions = knot_positions(schema.controls[c], curves[c]);
    errors[c].errors.resize(errors[c].positions.size());
    for (const double position : errors[c].positions) all.push_back({c, position});
  }
  if (all.size() > rig.remaining()) all.resize(rig.remaining());
  const double drop = 2e-6 * rig.diagonal();
  std::vector<SparseShape> found(all.size());
  EvaluationStage stage(progress, Phase::analysis, "measuring activation curves", all.size());
  evaluate_curve_errors(rig, curves, all, stage,
                        [&](std::size_t i, std::span<const float> error) { found[i] = make_sparse(0, error, drop); });
  for (std::size_t i = 0, k = 0; i < all.size(); ++i, ++k) {
    if (i > 0 && all[i].control != all[i - 1].control) k = 0;
    errors[all[i].control].errors[k] = std::move(found[i]);
  }
  return errors;
}

std::vector<double> validate_curves(RigEvaluator& rig, const std::vector<ControlCurve>& curves, std::uint64_t seed,
                                    Progress& progress) {
  const RigSchema& schema = rig.schema();
  // A budget is better spent on correctives.
  const int draws = rig.remaining() == UINT64_MAX ? validation_draws : 1;
  std::vector<ControlPosition> drawn;
  for (std::size_t c = 0; c < curves.size(); ++c)
    for (const bool up : {true, false}) {
      if (!has_side(schema.controls[c], up)) continue;
      Random random = open_stream(seed, Stream::curve_validation, 2 * c + up);
      for (int k = 0; k < draws; ++k) {
        const double position = 0.02 + 0.96 * random.uniform();
        drawn.push_back({c, up ? position : -position});
      }
    }
  if (drawn.size() > rig.remaining()) drawn.resize(rig.remaining());
  std::vector<double> distances(drawn.size());
  EvaluationStage stage(progress, Phase::analysis, "validating activation curves", drawn.size());
  evaluate_curve_errors(rig, curves, drawn, stage, [&](std::size_t i, std::span<const float> error) {
    for (std::size_t k = 0; k < error.size(); k += 3)
      distances[i] = std::max(distances[i], std::hypot(double(error[k]), error[k + 1], error[k + 2]));
  });
  std::vector<double> errors(curves.size());
  for (std::size_t i = 0; i < drawn.size(); ++i)
    errors[drawn[i].control] = std::max(errors[drawn[i].control], distances[i] / rig.diagonal());
  return errors;
}

}  // namespace fb::bake
