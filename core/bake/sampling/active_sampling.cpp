#include "bake/sampling/active_sampling.h"
#include "bake/dataset/open_source.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "bake/sampling/coverage.h"
#include "bake/sampling/plan_steps.h"
#include "bake/sampling/pose_generators.h"
#include "base/hash.h"

namespace fb::bake {
namespace {

constexpr std::size_t scored_at_once = 1000;
constexpr std::size_t stratum_count = 10;

// Which controls are far along, and toward which end: poses that share it are near-duplicates.
std::uint64_t gist_of(const RigSchema& schema, std::span<const float> pose) {
  std::vector<std::uint64_t> ends;
  for (std::size_t c = 0; c < pose.size(); ++c) {
    const Control& control = schema.controls[c];
    const float away = pose[c] - control.rest,
                room = away < 0 ? control.minimum - control.rest : control.maximum - control.rest;
    if (room != 0 && away / room >= far_along) ends.push_back(2 * c + (away > 0));
  }
  return hash64_of<std::uint64_t>(ends);
}

std::vector<float> scores_of(const RigSchema& schema, std::span<const float> pool, const EnsembleVariance& variance) {
  const std::size_t width = schema.control_count(), size = pool.size() / width;
  std::vector<float> scores;
  for (std::size_t first = 0; first < size; first += scored_at_once) {
    const std::size_t count = std::min(scored_at_once, size - first);
    const std::vector<float> some = variance(pool.subspan(first * width, count * width), count);
    if (some.size() != count) fail(Status::internal, "an ensemble scored %zu poses of %zu", some.size(), count);
    for (const float score : some)
      if (!(score >= 0 && std::isfinite(score)))
        fail(Status::not_finite, "an ensemble scored a pose %g", double(score));
    scores.insert(scores.end(), some.begin(), some.end());
  }
  return scores;
}

// Which tenth of the pool a pose is in by how far it is from rest altogether.
std::vector<std::uint8_t> strata_of(const RigSchema& schema, std::span<const float> pool) {
  const std::size_t width = schema.control_count(), size = pool.size() / width;
  std::vector<float> travel(size);
  for (std::size_t i = 0; i < pool.size(); ++i) {
    const Control& control = schema.controls[i % width];
    travel[i / width] += std::abs(pool[i] - control.rest) / control.reach();
  }
  std::vector<std::uint32_t> order(size);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return travel[a] < travel[b]; });
  std::vector<std::uint8_t> strata(size);
  for (std::size_t i = 0; i < size; ++i) strata[order[i]] = static_cast<std::uint8_t>(i * stratum_count / size);
  return strata;
}

// How many poses each stratum gives: in proportion to the root of its scores (Neyman's allocation), none more than it
// has.
std::vector<std::size_t> allotted(const std::vector<float>& scores, const std::vector<std::uint8_t>& strata,
                                  std::size_t count) {
  std::vector<double> weights(stratum_count);
  std::vector<std::size_t> sizes(stratum_count), parts(stratum_count);
  double sum = 0;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const double root = std::sqrt(double(scores[i]));
    weights[strata[i]] += root;
    sum += root;
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
    fail(Status::invalid_argument, "%zu poses cannot be chosen of %zu values for %zu controls", count, pool.size(),
         width);
  if (!(random_share >= 0 && random_share <= 1))
    fail(Status::invalid_argument, "a random share of %g is not in [0, 1]", random_share);
  const std::vector<float> scores = scores_of(schema, pool, variance);
  std::vector<std::uint32_t> order(size);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return scores[a] > scores[b]; });

  const auto by_score = count - static_cast<std::size_t>(std::llround(random_share * static_cast<double>(count)));
  const std::size_t alike = std::max<std::size_t>(2, count / 50);
  const std::vector<std::uint8_t> strata = strata_of(schema, pool);
  std::vector<std::size_t> wanted = allotted(scores, strata, by_score);
  std::vector<std::uint32_t> chosen;
  std::map<std::uint64_t, std::size_t> taken;
  // Takes poses in order that `may` allows; the others stay, in order.
  const auto take = [&](const auto& may) {
    std::vector<std::uint32_t> left;
    for (const std::uint32_t pose : order) {
      std::size_t& same = taken[gist_of(schema, pool.subspan(pose * width, width))];
      const bool chooses = chosen.size() < by_score && same < alike && may(pose);
      same += chooses;
      (chooses ? chosen : left).push_back(pose);
    }
    order = std::move(left);
  };
  take([&](std::uint32_t pose) { return wanted[strata[pose]] > 0 && wanted[strata[pose]]-- > 0; });
  take([](std::uint32_t) { return true; });  // what rounding and near-duplicates left open
  Random random = open_stream(seed, Stream::choice, 0);
  for (std::size_t i = 0; chosen.size() < count; ++i) {
    std::swap(order[i], order[i + random.below(static_cast<std::uint32_t>(order.size() - i))]);
    chosen.push_back(order[i]);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

SampleReport sample_actively(RigEvaluator& rig, const SamplingOptions& options, const ActiveSamplingOptions& choice,
                             const TrainEnsemble& ensemble, const std::filesystem::path& directory,
                             Progress& progress) {
  if (choice.rounds == 0 || choice.pool == 0 || !(choice.first_share > 0 && choice.first_share < 1))
    fail(Status::invalid_argument,
         "choosing poses: %u rounds, %u candidates a pose and a first share of %g make no choice", choice.rounds,
         choice.pool, choice.first_share);
  const EvaluationBudget budget(rig, options.rig_budget);
  std::optional<ControlResponses> made;
  const auto responses = [&]() -> const ControlResponses& { return made ? *made : made.emplace(rig, progress); };
  const RigSchema& schema = rig.schema();
  SamplingOptions first = options;
  // Each round asks for one pose again, to see that the rig is still the same.
  if (options.rig_budget > 0) first.rig_budget -= std::min<std::uint64_t>(choice.rounds, options.rig_budget - 1);
  const std::size_t width = schema.control_count(), poses = poses_to_draw(rig, first);
  first.rig_budget = 0;
  first.poses = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(static_cast<double>(poses) * choice.first_share));
  SampleReport report = sample_probed(rig, first, responses, directory, progress);
  const std::size_t others = poses - first.poses;
  for (std::uint32_t round = 0; round < choice.rounds; ++round) {
    const std::size_t count = others * (round + 1) / choice.rounds - others * round / choice.rounds;
    const std::string name = format("chosen_%u", round);
    if (count == 0) continue;
    const auto recorded = open_source(directory.string());
    const auto there = std::find_if(recorded->clips().begin(), recorded->clips().end(),
                                    [&](const Clip& clip) { return clip.name == name; });
    if (there != recorded->clips().end()) {
      if (there->frames != count)
        fail(Status::invalid_argument, "%s: holds poses chosen with other options; sample into a new folder",
             directory.c_str());
      continue;
    }
    const std::uint64_t seed = open_stream(options.seed, Stream::choice, round + 1).next();
    const std::vector<float> pool = draw_candidates(schema, responses(), options.mix, seed, count * choice.pool);
    const std::vector<std::uint32_t> chosen =
        select_poses(schema, pool, count, choice.random_share, ensemble(*recorded, round), seed);
    Clip clip{name, ClipKind::dense, Split::train, 30, count, {}};
    for (const std::uint32_t pose : chosen)
      clip.controls.insert(clip.controls.end(), pool.begin() + static_cast<std::ptrdiff_t>(pose * width),
                           pool.begin() + static_cast<std::ptrdiff_t>((pose + 1) * width));
    const SampleReport extended = extend_dataset(rig, {clip}, directory, progress);
    report.poses = extended.poses;
    report.evaluated += extended.evaluated;
  }
  report.rig_calls = budget.evaluated();
  return report;
}

}  // namespace fb::bake
