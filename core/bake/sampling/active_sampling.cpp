#include "bake/sampling/active_sampling.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "bake/dataset/dataset_source.h"
#include "bake/sampling/coverage.h"
#include "bake/sampling/pose_generators.h"
#include "bake/sampling/pose_plan.h"
#include "base/hash.h"
#include "base/output_lock.h"
#include "base/random_streams.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

constexpr std::size_t poses_per_call = 1000;  // of the ensemble
constexpr std::size_t stratum_count = 10;

// Hash of the controls that are nearly as active as the most active one, and of their ends: poses that share it are
// near-duplicates.
std::uint64_t strong_activation_hash(const RigSchema& schema, std::span<const float> pose) {
  std::vector<float> shares(pose.size());
  for (std::size_t c = 0; c < pose.size(); ++c) {
    const Control& control = schema.controls[c];
    const float away = pose[c] - control.rest,
                room = away < 0 ? control.minimum - control.rest : control.maximum - control.rest;
    if (room != 0) shares[c] = away / room;
  }
  const float least = strong_activation * *std::max_element(shares.begin(), shares.end());
  std::vector<std::uint64_t> ends;
  for (std::size_t c = 0; c < pose.size(); ++c)
    if (shares[c] > 0 && shares[c] >= least) ends.push_back(2 * c + (pose[c] > schema.controls[c].rest));
  return hash64_of<std::uint64_t>(ends);
}

std::vector<float> variances_of(const RigSchema& schema, std::span<const float> pool,
                                const EnsembleVariance& variance) {
  const std::size_t width = schema.control_count(), size = pool.size() / width;
  std::vector<float> variances;
  for (std::size_t first = 0; first < size; first += poses_per_call) {
    const std::size_t count = std::min(poses_per_call, size - first);
    const std::vector<float> some = variance(pool.subspan(first * width, count * width), count);
    if (some.size() != count)
      fail(Status::internal, "an ensemble gave variances of %zu poses for %zu", some.size(), count);
    for (const float value : some)
      if (!(value >= 0 && std::isfinite(value)))
        fail(Status::not_finite, "an ensemble gave a variance of %g", double(value));
    variances.insert(variances.end(), some.begin(), some.end());
  }
  return variances;
}

// The tenth of the pool each pose is in by its distance from rest: the sum over controls, in units of their reach.
std::vector<std::uint8_t> strata_of(const RigSchema& schema, std::span<const float> pool) {
  const std::size_t width = schema.control_count(), size = pool.size() / width;
  std::vector<float> distance(size);
  for (std::size_t i = 0; i < pool.size(); ++i) {
    const Control& control = schema.controls[i % width];
    distance[i / width] += std::abs(pool[i] - control.rest) / control.reach();
  }
  std::vector<std::uint32_t> order(size);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return distance[a] < distance[b]; });
  std::vector<std::uint8_t> strata(size);
  for (std::size_t i = 0; i < size; ++i) strata[order[i]] = static_cast<std::uint8_t>(i * stratum_count / size);
  return strata;
}

// Poses to select in each stratum: in proportion to the sum of standard deviations (Neyman allocation), at most its
// size.
std::vector<std::size_t> allocate(const std::vector<float>& variances, const std::vector<std::uint8_t>& strata,
                                  std::size_t count) {
  std::vector<double> weights(stratum_count);
  std::vector<std::size_t> sizes(stratum_count), parts(stratum_count);
  double sum = 0;
  for (std::size_t i = 0; i < variances.size(); ++i) {
    const double deviation = std::sqrt(double(variances[i]));
    weights[strata[i]] += deviation;
    sum += deviation;
    ++sizes[strata[i]];
  }
  for (std::size_t s = 0; s < stratum_count; ++s) {
    const double part = sum > 0 ? weights[s] / sum : 1.0 / stratum_count;
    parts[s] = std::min(sizes[s], static_cast<std::size_t>(part * static_cast<double>(count)));
  }
  return parts;
}

}  // namespace

std::vector<std::uint32_t> select_poses(const RigSchema& schema, std::span<const float> pool, std::size_t count,
                                        double random_share, const EnsembleVariance& variance, std::uint64_t seed) {
  const std::size_t width = schema.control_count(), size = pool.size() / width;
  if (pool.size() != size * width || size < count)
    fail(Status::invalid_argument, "%zu poses cannot be selected from %zu values for %zu controls", count, pool.size(),
         width);
  if (!(random_share >= 0 && random_share <= 1))
    fail(Status::invalid_argument, "a random share of %g is not in [0, 1]", random_share);
  const std::vector<float> variances = variances_of(schema, pool, variance);
  std::vector<std::uint32_t> order(size);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return variances[a] > variances[b]; });

  const auto by_variance = count - static_cast<std::size_t>(std::llround(random_share * static_cast<double>(count)));
  const std::size_t most_duplicates = std::max<std::size_t>(2, count / 50);
  const std::vector<std::uint8_t> strata = strata_of(schema, pool);
  std::vector<std::size_t> wanted = allocate(variances, strata, by_variance);
  std::vector<std::uint32_t> selected;
  std::map<std::uint64_t, std::size_t> duplicates;  // selected, by strong_activation_hash
  // Selects the poses that `may` allows, in order; the others stay, in order.
  const auto take = [&](const auto& may) {
    std::vector<std::uint32_t> left;
    for (const std::uint32_t pose : order) {
      std::size_t& same = duplicates[strong_activation_hash(schema, pool.subspan(pose * width, width))];
      const bool selects = selected.size() < by_variance && same < most_duplicates && may(pose);
      same += selects;
      (selects ? selected : left).push_back(pose);
    }
    order = std::move(left);
  };
  take([&](std::uint32_t pose) { return wanted[strata[pose]] > 0 && wanted[strata[pose]]-- > 0; });
  take([](std::uint32_t) { return true; });  // what rounding and near-duplicates left
  Random random = open_stream(seed, Stream::choice, 0);
  for (std::size_t i = 0; selected.size() < count; ++i) {
    std::swap(order[i], order[i + random.below(static_cast<std::uint32_t>(order.size() - i))]);
    selected.push_back(order[i]);
  }
  std::sort(selected.begin(), selected.end());
  return selected;
}

namespace {

bool is_recorded(const Source& recorded, const std::string& name, std::size_t count,
                 const std::filesystem::path& directory) {
  const auto existing = std::find_if(recorded.clips().begin(), recorded.clips().end(),
                                     [&](const Clip& clip) { return clip.name == name; });
  if (existing == recorded.clips().end()) return false;
  if (existing->frames != count)
    fail(Status::invalid_argument, "%s: holds poses selected with other options; sample into a new folder",
         shown(directory).c_str());
  return true;
}

Clip clip_of(const std::string& name, std::span<const float> pool, std::span<const std::uint32_t> selected,
             std::size_t width) {
  Clip clip{name, ClipKind::dense, Split::train, 30, selected.size(), {}};
  for (const std::uint32_t pose : selected) {
    const std::span<const float> controls = pool.subspan(pose * width, width);
    clip.controls.insert(clip.controls.end(), controls.begin(), controls.end());
  }
  return clip;
}

}  // namespace

std::uint64_t poses_before_ensemble(const Source& rig, const SamplingOptions& options,
                                    const ActiveSamplingOptions& active) {
  const std::size_t poses = poses_to_draw(rig, options);
  const std::size_t answered =
      options.rig_budget > 0 ? std::min(poses, ControlResponses::poses_within(rig.schema(), options.rig_budget)) : 0;
  return std::max<std::uint64_t>(
      1, answered + static_cast<std::uint64_t>(static_cast<double>(poses - answered) * active.first_share));
}

SampleReport sample_actively(RigEvaluator& rig, const SamplingOptions& options, const ActiveSamplingOptions& active,
                             const TrainEnsemble& ensemble, const std::filesystem::path& directory,
                             Progress& progress) {
  if (active.rounds == 0 || active.pool == 0 || !(active.first_share > 0 && active.first_share < 1))
    fail(Status::invalid_argument,
         "active sampling: %u rounds, %u candidates a pose and a first share of %g select nothing", active.rounds,
         active.pool, active.first_share);
  const OutputLock lock = OutputLock::of_folder(directory);
  const EvaluationBudget budget(rig, options.rig_budget);
  std::optional<ControlResponses> evaluated;
  const auto responses = [&]() -> const ControlResponses& {
    return evaluated ? *evaluated : evaluated.emplace(rig, options.rig_budget, progress);
  };
  SamplingOptions first = options;
  const std::size_t poses = poses_to_draw(rig, options);
  first.poses = poses_before_ensemble(rig, options, active);
  SampleReport report = sample_with_responses(rig, first, responses, directory, progress);
  const std::size_t others = poses - first.poses;
  for (std::uint32_t round = 0; round < active.rounds; ++round) {
    const std::size_t count = others * (round + 1) / active.rounds - others * round / active.rounds;
    const std::string name = format("%s%u", round_clip, round);
    if (count == 0) continue;
    DatasetSource recorded(directory);  // whose lock is this call's
    if (is_recorded(recorded, name, count, directory)) continue;
    const std::uint64_t seed = seed_of(options.seed, Stream::sampling_rounds, round);
    const std::vector<float> pool = draw_candidates(rig.schema(), responses(), options, seed, count * active.pool);
    const std::vector<std::uint32_t> selected =
        select_poses(rig.schema(), pool, count, active.random_share, ensemble(recorded, round), seed);
    const Clip clip = clip_of(name, pool, selected, rig.schema().control_count());
    const SampleReport extended = extend_dataset(rig, {clip}, directory, progress, options.skip_failing);
    report.poses = extended.poses;
    report.left_out = extended.left_out;
    report.evaluated += extended.evaluated;
  }
  report.rig_calls = budget.evaluated();
  report.asked = budget.requested();
  return report;
}

}  // namespace fb::bake
