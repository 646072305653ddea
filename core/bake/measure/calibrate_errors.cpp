#include "bake/measure/calibrate_errors.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "bake/measure/error_regions.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/face_map.h"
#include "bake/measure/measured_face.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t least_calibration_poses = 30, most_calibration_poses = 2000;
constexpr int fit_updates = 100;
constexpr double prior_poses = 0.3;
constexpr double constant_share = 0.05;  // of the mean squared error, that is expected of the rest pose before
constexpr double least_weight = 1e-3;    // of the largest one, expected of a control before
constexpr double least_error = 1e-7;     // over D
constexpr double trained_margin = 5;     // in 255ths of a control's range
constexpr double largest_weight = 0.9;   // of those that a byte stands for

// Mean squared errors of each pose, regions x poses, in the rig's units.
std::vector<std::vector<double>> squared_errors(const PackedModel& model, const PoseSet& poses,
                                                const ErrorRegions& regions, const Parallel& parallel) {
  const std::size_t controls = model.schema.control_count(), surface = 3 * model.rest.surface_vertex_count();
  const std::vector<float> all = poses.controls();
  std::vector<std::vector<double>> squares(regions.names.size(), std::vector<double>(poses.size()));
  const Parallel workers = poses.readers(parallel);
  MeasuredFace face(model, worker_count(workers));
  std::vector<std::vector<float>> truths(worker_count(workers), std::vector<float>(model.rest.points.size()));
  parallel_for(workers, poses.size(), [&](std::size_t i, std::size_t w) {
    const std::vector<float>& truth = truths[w];
    poses.read_points(i, 1, truths[w]);
    const std::span<const float> predicted = face.positions(&all[i * controls], w);
    for (std::size_t k = 0; k < surface; ++k) {
      const double d = double(predicted[k]) - truth[k];
      squares[regions.of_vertex[k / 3]][i] += d * d;
    }
    for (std::size_t r = 0; r < squares.size(); ++r) squares[r][i] /= static_cast<double>(regions.sizes[r]);
  });
  return squares;
}

double mean_of(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

double sum_of(std::span<const double> weights, std::span<const float> inputs) {
  double sum = weights.back();
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (inputs[i] != 0) sum += weights[i] * inputs[i];
  return sum;
}

// What a region's weights are expected to be before: in proportion to squared motion.
std::vector<double> prior_weights(std::span<const double> squared_motion, std::span<const float> inputs,
                                  std::span<const double> values) {
  const std::size_t controls = squared_motion.size();
  const double average = mean_of(values);
  std::vector<double> prior(squared_motion.begin(), squared_motion.end());
  prior.push_back(0);
  double moved = 0;
  for (std::size_t i = 0; i < values.size(); ++i) moved += sum_of(prior, inputs.subspan(i * controls, controls));
  const double scale = moved > 0 ? average * static_cast<double>(values.size()) / moved : 0;
  const double least = std::max(least_weight * *std::max_element(prior.begin(), prior.end()) * scale, 1e-3 * average);
  for (double& weight : prior) weight = std::max(weight * scale, least);
  prior.back() = constant_share * average;
  return prior;
}

// Poses and what their controls add to errors.
struct Measured {
  std::vector<float> inputs;                 // poses x controls
  std::vector<std::vector<double>> squares;  // regions x poses
};

// From how far controls are moved to what their weights are multiplied by.
Measured measured_on(const PackedModel& model, const PoseSet& poses, const ErrorRegions& regions,
                     const Parallel& parallel) {
  Measured measured{reached(model.schema, poses.controls()), squared_errors(model, poses, regions, parallel)};
  for (float& input : measured.inputs) input *= std::sqrt(input);
  const double least = std::pow(least_error * model.rest.diagonal(), 2);
  for (std::vector<double>& values : measured.squares) {
    const double floor = std::max(least, 1e-4 * mean_of(values));
    for (double& value : values) value += floor;
  }
  return measured;
}

// The weights of one region, and its constant behind them: their proportions from many poses, their size from those
// that nothing was fitted to.
std::vector<double> region_weights(std::size_t region, std::span<const double> squared_motion, const Measured& many,
                                   const Measured& held_back) {
  const std::size_t controls = squared_motion.size();
  const std::vector<double>& values = many.squares[region];
  std::vector<double> weights =
      fit_nonnegative(many.inputs, controls, values, prior_weights(squared_motion, many.inputs, values), prior_poses);
  // The middle of errors, not the mean of their squares: more are within a factor of two of it.
  const std::vector<double>& unseen = held_back.squares[region];
  double logarithms = 0;
  for (std::size_t i = 0; i < unseen.size(); ++i)
    logarithms += std::log(unseen[i] / sum_of(weights, std::span(held_back.inputs).subspan(i * controls, controls)));
  const double centre = std::exp(logarithms / static_cast<double>(unseen.size()));
  for (double& weight : weights) weight *= centre;
  return weights;
}

void find_trained_values(ExpectedErrors& expected, const RigSchema& schema, std::span<const float> poses) {
  const std::size_t controls = schema.control_count();
  for (std::size_t c = 0; c < controls; ++c) {
    float low = schema.controls[c].rest, high = low;
    for (std::size_t at = c; at < poses.size(); at += controls) {
      low = std::min(low, poses[at]);
      high = std::max(high, poses[at]);
    }
    const auto place = [&, &control = schema.controls[c]](float value, double margin) {
      const double steps = 255 * (double(value) - control.minimum) / (double(control.maximum) - control.minimum);
      return static_cast<std::uint8_t>(std::clamp(std::round(steps + margin), 0.0, 255.0));
    };
    expected.trained_low.push_back(place(low, -trained_margin));
    expected.trained_high.push_back(place(high, trained_margin));
  }
}

constexpr std::size_t mask_bits = 64;

void set_mask_bit(std::span<std::uint64_t> words, std::size_t bit) {
  words[bit / mask_bits] |= std::uint64_t(1) << bit % mask_bits;
}

// Pairs of controls that move a vertex both, and are in no training pose both half as far as counts.
void find_untrained_pairs(ExpectedErrors& expected, const FaceMap& map, std::size_t controls, std::size_t vertices,
                          std::span<const float> inputs) {
  const std::size_t words = (controls + mask_bits - 1) / mask_bits, mask_words = (vertices + mask_bits - 1) / mask_bits;
  std::vector<std::uint64_t> trained(controls * words), active(words), moved(controls * mask_words);
  std::vector<std::size_t> list;
  for (std::size_t at = 0; at < inputs.size(); at += controls) {
    std::fill(active.begin(), active.end(), 0);
    list.clear();
    for (std::size_t c = 0; c < controls; ++c)
      if (inputs[at + c] >= together / 2) {
        set_mask_bit(active, c);
        list.push_back(c);
      }
    for (const std::size_t c : list)
      for (std::size_t w = 0; w < words; ++w) trained[c * words + w] |= active[w];
  }
  for (std::size_t c = 0; c < controls; ++c)
    for (const std::uint32_t v : map.moved_by(c)) set_mask_bit(std::span(moved).subspan(c * mask_words, mask_words), v);
  expected.untrained_pairs.resize(pair_bytes(controls));
  for (std::size_t b = 1; b < controls; ++b)
    for (std::size_t a = 0; a < b; ++a) {
      if (trained[b * words + a / mask_bits] >> a % mask_bits & 1) continue;
      std::uint64_t shared = 0;
      for (std::size_t w = 0; w < mask_words; ++w) shared |= moved[a * mask_words + w] & moved[b * mask_words + w];
      if (shared != 0) expected.set_untrained(a, b);
    }
}

// Mean squares of how far controls alone move the vertices of regions: regions x controls, over D^2.
std::vector<std::vector<double>> squared_motions(const FaceMap& map, const ErrorRegions& regions,
                                                 std::size_t controls) {
  std::vector<std::vector<double>> motions(regions.names.size(), std::vector<double>(controls));
  for (std::size_t c = 0; c < controls; ++c)
    for (std::size_t v = 0; v < regions.of_vertex.size(); ++v)
      motions[regions.of_vertex[v]][c] += double(map.motion(c, v)) * map.motion(c, v);
  for (std::size_t r = 0; r < motions.size(); ++r)
    for (double& motion : motions[r]) motion /= static_cast<double>(regions.sizes[r]);
  return motions;
}

}  // namespace

std::vector<float> reached(const RigSchema& schema, std::span<const float> poses) {
  std::vector<float> shares(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Control& control = schema.controls[i % schema.control_count()];
    const float value = std::clamp(poses[i], control.minimum, control.maximum);
    shares[i] = std::min(std::abs(value - control.rest) / control.reach(), 1.0f);
  }
  return shares;
}

std::vector<double> fit_nonnegative(std::span<const float> inputs, std::size_t width, std::span<const double> values,
                                    std::span<const double> prior, double prior_values) {
  std::vector<double> weights(prior.begin(), prior.end()), more(width + 1), less(width + 1);
  for (int update = 0; update < fit_updates; ++update) {
    for (std::size_t i = 0; i <= width; ++i) {
      more[i] = prior_values * prior[i] / (weights[i] * weights[i]);
      less[i] = prior_values / weights[i];
    }
    for (std::size_t n = 0; n < values.size(); ++n) {
      const auto row = inputs.subspan(n * width, width);
      const double by = 1 / sum_of(weights, row), raise = values[n] * by * by;
      for (std::size_t i = 0; i < width; ++i)
        if (row[i] != 0) {
          more[i] += row[i] * raise;
          less[i] += row[i] * by;
        }
      more[width] += raise;
      less[width] += by;
    }
    for (std::size_t i = 0; i <= width; ++i) weights[i] *= std::sqrt(more[i] / less[i]);
  }
  return weights;
}

ExpectedErrors calibrate_errors(const PackedModel& model, const PoseSet& training,
                                std::span<const std::uint32_t> held_back, std::uint64_t seed,
                                const Parallel& parallel) {
  const PoseSet poses = training.picked(held_back).subsampled(most_calibration_poses);
  if (poses.size() < least_calibration_poses) return {};
  const FaceMap map(model, parallel);
  const std::size_t controls = model.schema.control_count();
  const ErrorRegions regions = error_regions(model, map, seed);
  const std::vector<std::vector<double>> motions = squared_motions(map, regions, controls);
  const Measured many = measured_on(model, training.subsampled(most_calibration_poses), regions, parallel),
                 unseen = measured_on(model, poses, regions, parallel);
  std::vector<std::vector<double>> weights(regions.names.size());
  parallel_for(parallel, weights.size(),
               [&](std::size_t r, std::size_t) { weights[r] = region_weights(r, motions[r], many, unseen); });

  ExpectedErrors expected;
  double largest = 0;
  for (const std::vector<double>& of_region : weights)
    largest = std::max(largest, *std::max_element(of_region.begin(), of_region.end()));
  expected.unit = static_cast<float>(std::sqrt(largest / largest_weight));
  const double squared_unit = double(expected.unit) * expected.unit;
  expected.runs = regions.runs;
  for (std::size_t r = 0; r < weights.size(); ++r)
    expected.regions.push_back({regions.names[r], static_cast<float>(weights[r].back() / squared_unit)});
  for (std::size_t c = 0; c < controls; ++c)
    for (const std::vector<double>& of_region : weights)
      expected.weights.push_back(encoded_weight(of_region[c] / squared_unit));
  const std::vector<float> trained = training.controls();
  find_trained_values(expected, model.schema, trained);
  find_untrained_pairs(expected, map, controls, model.rest.surface_vertex_count(), reached(model.schema, trained));
  return expected;
}

}  // namespace fb::bake
