#include "bake/compress/fit_target.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "base/keep_asking.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Two rungs to a doubling: from 2.5e-7 to 7.2e-4 of the diagonal.
constexpr int rungs = 24;
constexpr double finest_scale = 2.5e-7;

Precision precision_at(int rung, int weight_bits) {
  return {finest_scale * std::exp2(rung / 2.0), weight_bits};
}

// The first number of [first, last) for which `before` is false; it is false for all after it.
template <class Before>
int boundary(int first, int last, const Before& before) {
  while (first < last) {
    const int middle = first + (last - first) / 2;
    if (before(middle))
      first = middle + 1;
    else
      last = middle;
  }
  return first;
}

// The precisions of one number of weight bits that are within max_bytes: rungs from `finest` on.
struct Ladder {
  int weight_bits, finest;
  double error;  // at `finest`
};

// Packs candidates, and measures each once.
class Candidates {
 public:
  using Error = std::function<double(const PackedModel&)>;
  using Bytes = std::function<std::uint64_t(const PackedModel&)>;

  Candidates(const FaceModel& model, const FitInputs& inputs, const Error& error, const Bytes& bytes,
             const Parallel& parallel, Progress& progress)
      : pca_(model, inputs.covariance, BlockwisePcaOptions{}.block_vertices, parallel, inputs.direct_sizes),
        inputs_(&inputs),
        parallel_(parallel),
        measure_error_(&error),
        measure_bytes_(&bytes),
        progress_(&progress) {}

  double error(const Precision& precision) { return measured(errors_, precision, *measure_error_); }
  std::uint64_t bytes(const Precision& precision) { return measured(bytes_, precision, *measure_bytes_); }

  Fitted fitted(const FitChoice& choice) {
    build(choice.precision);
    return {blockwise_.model, packing(choice.precision), packed_, choice, {}};
  }

 private:
  using Key = std::pair<double, int>;
  static Key key_of(const Precision& precision) { return {precision.scale, precision.weight_bits}; }

  PackOptions packing(const Precision& precision) const {
    PackOptions options = precision.pack();
    options.coefficient_sizes = blockwise_.coefficient_sizes;
    options.normal_weight = inputs_->normal_weight;
    options.samples = samples_;
    return options;
  }

  const PackedModel& build(const Precision& precision) {
    const Key key = key_of(precision);
    if (built_ == key) return packed_;
    keep_asking(*progress_, [&] {
      if (built_.first != key.first) {
        blockwise_ = pca_.truncated(precision.scale);
        if (inputs_->samples) samples_ = inputs_->samples(blockwise_.model);
      }
      packed_ = pack_model(blockwise_.model, packing(precision), without_asking(parallel_));
    });
    built_ = key;
    return packed_;
  }

  template <class Number, class Measure>
  Number measured(std::map<Key, Number>& known, const Precision& precision, const Measure& measure) {
    const auto found = known.find(key_of(precision));
    if (found != known.end()) return found->second;
    const Number number = measure(build(precision));
    known[key_of(precision)] = number;
    progress_->step(++measurements_);
    return number;
  }

  BlockwisePca pca_;
  const FitInputs* inputs_;
  const Parallel parallel_;
  const Error* measure_error_;
  const Bytes* measure_bytes_;
  Progress* progress_;
  std::map<Key, double> errors_;
  std::map<Key, std::uint64_t> bytes_;
  std::uint64_t measurements_ = 0;
  Key built_{};  // of blockwise_ and packed_
  BlockwiseModel blockwise_;
  std::vector<float> samples_;  // of blockwise_
  PackedModel packed_;
};

bool met(const FitTarget& target, const FitChoice& choice) {
  return (target.max_bytes == 0 || choice.bytes <= target.max_bytes) &&
         (target.max_error <= 0 || choice.error <= target.max_error);
}

std::string cost_text(const FitChoice& choice) {
  return format("%llu bytes, largest error %.3g of the diagonal on validation poses",
                static_cast<unsigned long long>(choice.bytes), choice.error);
}

// What is the matter with a choice that does not meet the target.
std::string unmet_text(const FitTarget& target, const FitChoice& choice) {
  if (target.max_bytes > 0 && choice.bytes > target.max_bytes)
    return format("asked for %llu bytes, the smallest reached is %s", static_cast<unsigned long long>(target.max_bytes),
                  cost_text(choice).c_str());
  return format("asked for an error of %.3g of the diagonal, the smallest reached%s is %s", target.max_error,
                target.max_bytes > 0 ? " within the bytes" : "", cost_text(choice).c_str());
}

}  // namespace

PackOptions Precision::pack() const {
  PackOptions options;
  options.first_bits = options.hidden_bits = options.output_bits = weight_bits;
  options.basis_tolerance = 2 * scale;
  options.drop = 3.5 * scale;
  options.step = 8.0 / 3 * scale;
  options.step_lambda = 8;
  return options;
}

FitChoice choose_precision(const FitTarget& target, const std::function<std::uint64_t(const Precision&)>& bytes,
                           const std::function<double(const Precision&)>& error) {
  if (target.max_bytes == 0 && target.max_error <= 0)
    fail(Status::invalid_argument, "a target needs max_bytes or max_error");
  const auto chosen = [&](const Precision& precision) {
    return FitChoice{precision, bytes(precision), error(precision)};
  };

  std::vector<Ladder> ladders;
  for (const int bits : {8, 16}) {
    const auto too_much = [&](int rung) {
      return target.max_bytes > 0 && bytes(precision_at(rung, bits)) > target.max_bytes;
    };
    const int finest = boundary(0, rungs, too_much);
    if (finest < rungs) ladders.push_back({bits, finest, error(precision_at(finest, bits))});
  }
  if (ladders.empty()) return chosen(precision_at(rungs - 1, 8));
  const Ladder& best = *std::ranges::min_element(ladders, {}, &Ladder::error);
  if (target.max_error <= 0) return chosen(precision_at(best.finest, best.weight_bits));

  const double allowed = std::max(target.max_error, 1.01 * best.error);
  std::optional<FitChoice> smallest;
  for (const Ladder& ladder : ladders) {
    if (ladder.error > allowed) continue;
    const int beyond = boundary(ladder.finest + 1, rungs,
                                [&](int rung) { return error(precision_at(rung, ladder.weight_bits)) <= allowed; });
    const FitChoice choice = chosen(precision_at(beyond - 1, ladder.weight_bits));
    if (!smallest || choice.bytes < smallest->bytes) smallest = choice;
  }
  return *smallest;
}

Fitted fit_target(const FaceModel& model, const FitInputs& inputs, const FitTarget& target,
                  const std::function<double(const PackedModel&)>& error,
                  const std::function<std::uint64_t(const PackedModel&)>& bytes, const Parallel& parallel,
                  Progress& progress) {
  constexpr std::uint64_t most_measured = 24;  // bytes and error on both ladders
  progress.begin(Phase::packing, "fitting bytes and error", most_measured);
  Candidates candidates(model, inputs, error, bytes, parallel, progress);
  const auto choose = [&](const FitTarget& wanted) {
    return choose_precision(
        wanted, [&](const Precision& precision) { return candidates.bytes(precision); },
        [&](const Precision& precision) { return candidates.error(precision); });
  };
  const FitChoice choice = choose(target);
  std::string unmet;
  if (!met(target, choice)) {
    unmet = unmet_text(target, choice);
    if (!target.force && target.max_bytes > 0 && target.max_error > 0) {
      const FitChoice larger = choose({.max_error = target.max_error});
      if (met({.max_error = target.max_error}, larger)) unmet += "; with that error it takes " + cost_text(larger);
    }
    if (!target.force) fail(Status::limit, "%s", unmet.c_str());
  }
  progress.step(most_measured);
  progress.note(format("fitted: %s (basis precise to %.2g of it, weights of %d bits)", cost_text(choice).c_str(),
                       choice.precision.scale, choice.precision.weight_bits));
  Fitted fitted = candidates.fitted(choice);
  fitted.unmet = std::move(unmet);
  return fitted;
}

}  // namespace fb::bake
