#include "bake/analysis/live/excitation_curves.h"

#include <algorithm>
#include <cmath>

#include "bake/analysis/blendshape_parts.h"
#include "base/random.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t block_controls = 24;  // their samples are held together: at most 24 a side and control
constexpr int waves = 6;
constexpr int first_places = 8;  // of a side
constexpr std::size_t most_telling = 4;

struct Wanted {
  std::size_t control;
  double place;
};

void insert(CurveSamples& samples, double place, std::span<const float> displacement) {
  const auto at = std::lower_bound(samples.places.begin(), samples.places.end(), place) - samples.places.begin();
  samples.places.insert(samples.places.begin() + at, place);
  samples.displacements.emplace(samples.displacements.begin() + at, displacement.begin(), displacement.end());
}

// Samples of the first places of some controls; fewer places where the budget, spread evenly, is short.
std::vector<Wanted> first_wave(const RigSchema& schema, std::size_t begin, std::size_t end, int places) {
  std::vector<Wanted> wanted;
  for (std::size_t c = begin; c < end; ++c)
    for (const bool up : {true, false})
      for (int k = 1; k <= places && has_side(schema.controls[c], up); ++k)
        wanted.push_back({c, (up ? 1.0 : -1.0) * k / places});
  return wanted;
}

// Asks the rig for single controls and hands `take` what the curves are off there.
template <class Take>
void evaluate_misses(RigEvaluator& rig, const std::vector<ControlCurve>& curves, const std::vector<Wanted>& wanted,
                     EvaluationStage& stage, const Take& take) {
  rig.evaluate_each(
      wanted.size(), stage,
      [&](std::size_t i, std::span<float> pose) {
        pose[wanted[i].control] = value_at(rig.schema().controls[wanted[i].control], wanted[i].place);
      },
      [&](std::size_t i, std::span<const float> pose, std::span<float> displacement) {
        curves[wanted[i].control].part.add(pose, rig.rest_pose(), 1, -1, displacement);
        take(i, std::span<const float>(displacement));
      });
}

}  // namespace

std::vector<ControlCurve> fit_excitations(RigEvaluator& rig, const AnalysisOptions& options, std::vector<float>& motion,
                                          Progress& progress) {
  const RigSchema& schema = rig.schema();
  const std::size_t width = schema.control_count(), vertices = rig.coordinate_count() / 3;
  const CurveLimits limits{options.curve_tolerance * rig.diagonal(), 1e-6 * rig.diagonal(), options.max_knots};
  motion.assign(width * vertices, 0);
  std::vector<ControlCurve> curves(width);
  int places = first_places;
  while (places > 1 && first_wave(schema, 0, width, places).size() > rig.remaining() / 2) places /= 2;
  if (places < first_places)
    progress.note(format("the budget of rig calls allows %d of %d places on each side of a control at first", places,
                         first_places));
  for (std::size_t begin = 0; begin < width; begin += block_controls) {
    const std::size_t end = std::min(width, begin + block_controls);
    std::vector<CurveSamples> samples(end - begin);
    for (std::size_t c = begin; c < end; ++c) samples[c - begin].control = static_cast<std::uint32_t>(c);
    // What later controls need at the least is kept back.
    const std::size_t reserved = first_wave(schema, end, width, places).size();
    for (int wave = 0; wave < waves; ++wave) {
      std::vector<Wanted> wanted;
      if (wave == 0) {
        wanted = first_wave(schema, begin, end, places);
      } else {
        std::vector<std::vector<double>> bent(end - begin);
        parallel_for(rig.parallel(), bent.size(), [&](std::size_t i, std::size_t) {
          if (!samples[i].places.empty()) bent[i] = bent_places(samples[i], limits);
        });
        for (std::size_t i = 0; i < bent.size(); ++i)
          for (const double place : bent[i]) wanted.push_back({begin + i, place});
      }
      const std::uint64_t left = rig.remaining() > reserved ? rig.remaining() - reserved : 0;
      if (wanted.size() > left) wanted.resize(left);
      if (wanted.empty()) break;
      std::vector<std::vector<float>> answers(wanted.size());
      EvaluationStage stage(progress, format("evaluating controls %zu to %zu of %zu", begin + 1, end, width),
                            wanted.size());
      rig.evaluate_each(
          wanted.size(), stage,
          [&](std::size_t i, std::span<float> pose) {
            pose[wanted[i].control] = value_at(schema.controls[wanted[i].control], wanted[i].place);
          },
          [&](std::size_t i, std::span<const float>, std::span<float> displacement) {
            answers[i].assign(displacement.begin(), displacement.end());
          });
      for (std::size_t i = 0; i < wanted.size(); ++i)
        insert(samples[wanted[i].control - begin], wanted[i].place, answers[i]);
    }
    parallel_for(rig.parallel(), end - begin, [&](std::size_t i, std::size_t) {
      if (samples[i].places.empty()) return;
      curves[begin + i] = fit_curve(schema.controls[begin + i], samples[i], limits);
      float* row = motion.data() + (begin + i) * vertices;
      for (const std::vector<float>& d : samples[i].displacements)
        for (std::size_t v = 0; v < vertices; ++v) {
          const double squares =
              double(d[3 * v]) * d[3 * v] + double(d[3 * v + 1]) * d[3 * v + 1] + double(d[3 * v + 2]) * d[3 * v + 2];
          row[v] = std::max(row[v], static_cast<float>(std::sqrt(squares) / rig.diagonal()));
        }
    });
  }
  return curves;
}

std::vector<double> telling_places(const Control& control, const ControlCurve& curve) {
  std::vector<double> places;
  for (const bool up : {true, false})
    if (has_side(control, up)) places.push_back(up ? 1 : -1);
  const auto add = [&](double place) {
    if (places.size() < most_telling && has_side(control, place > 0) &&
        std::find(places.begin(), places.end(), place) == places.end())
      places.push_back(place);
  };
  for (const double knot : curve.knots) add(knot);
  for (const double place : {0.5, -0.5, 0.25, 0.75, -0.75}) add(place);
  return places;
}

std::vector<CurveErrors> measure_curves(RigEvaluator& rig, const std::vector<ControlCurve>& curves,
                                        Progress& progress) {
  const RigSchema& schema = rig.schema();
  std::vector<CurveErrors> errors(curves.size());
  std::vector<Wanted> wanted;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    errors[c].places = telling_places(schema.controls[c], curves[c]);
    errors[c].errors.resize(errors[c].places.size());
    for (const double place : errors[c].places) wanted.push_back({c, place});
  }
  if (wanted.size() > rig.remaining()) wanted.resize(rig.remaining());
  const double drop = 2e-6 * rig.diagonal();
  std::vector<SparseShape> answers(wanted.size());
  EvaluationStage stage(progress, "checking single controls", wanted.size());
  evaluate_misses(rig, curves, wanted, stage,
                  [&](std::size_t i, std::span<const float> miss) { answers[i] = make_sparse(0, miss, drop); });
  for (std::size_t i = 0, place = 0; i < wanted.size(); ++i, ++place) {
    if (i > 0 && wanted[i].control != wanted[i - 1].control) place = 0;
    errors[wanted[i].control].errors[place] = std::move(answers[i]);
  }
  return errors;
}

double test_curves(RigEvaluator& rig, const std::vector<ControlCurve>& curves, std::uint64_t seed, Progress& progress) {
  const RigSchema& schema = rig.schema();
  std::vector<Wanted> wanted;
  for (std::size_t c = 0; c < curves.size(); ++c)
    for (const bool up : {true, false}) {
      if (!has_side(schema.controls[c], up)) continue;
      Random random(seed, std::uint64_t{9} << 48 | (2 * c + up));
      const double place = 0.02 + 0.96 * random.uniform();
      wanted.push_back({c, up ? place : -place});
    }
  if (wanted.size() > rig.remaining()) wanted.resize(rig.remaining());
  std::vector<double> errors(wanted.size());
  EvaluationStage stage(progress, "testing single controls", wanted.size());
  evaluate_misses(rig, curves, wanted, stage, [&](std::size_t i, std::span<const float> miss) {
    for (std::size_t k = 0; k < miss.size(); k += 3)
      errors[i] = std::max(errors[i], std::hypot(double(miss[k]), miss[k + 1], miss[k + 2]));
  });
  double largest = 0;
  for (const double error : errors) largest = std::max(largest, error / rig.diagonal());
  return largest;
}

}  // namespace fb::bake
