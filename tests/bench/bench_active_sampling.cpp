// What selecting poses by variance saves, by a quick method: bench_active_sampling RIG [POSES]
// Trains on POSES poses of the dense mix, on two and four times as many, and on POSES of which three quarters were
// selected in rounds; all networks take the same number of steps. Errors are on poses of the same mix, the rig's own
// shots of the split train (trained on by none) and test poses of another seed. Test clips are not used.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "bake/dataset/open_source.h"
#include "bake/sampling/active_sampling.h"
#include "bake/sampling/pose_plan.h"
#include "quick_method.h"

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t steps = 6000, unseen = 1000;
const Parallel parallel{1};

struct Bench {
  explicit Bench(RigEvaluator& rig) : method(rig, 200), responses(rig, 0, silent_progress()), schema(rig.schema()) {
    add("poses of the mix", draw_candidates(schema, responses, {}, 999, unseen));
    std::vector<float> shots;
    for (const Clip& clip : rig.clips())
      if (clip.split == Split::train && clip.kind == ClipKind::shot)
        shots.insert(shots.end(), clip.controls.begin(), clip.controls.end());
    if (!shots.empty()) add("shots", std::move(shots));
    for (const Clip& clip : make_test_poses(schema, 4711)) add(clip.name, clip.controls);
  }

  void add(const std::string& name, std::vector<float> controls) {
    std::vector<float> truth = method.residuals_of(controls);
    sets.push_back({name, std::move(controls), std::move(truth)});
  }

  std::vector<DenseLayer> train(std::span<const float> controls, std::span<const float> residuals,
                                std::uint64_t seed) const {
    TrainingPlan plan;
    plan.widths = {128, 128};
    plan.learning_rate = 2e-3f;
    plan.epochs = static_cast<std::uint32_t>(steps * plan.batch / (controls.size() / method.width()));
    plan.seed = seed;
    plan.parallel = parallel;
    return method.train(controls, residuals, plan);
  }

  void print(const char* how, std::span<const float> controls, std::span<const float> residuals) const {
    const auto layers = train(controls, residuals, 1);
    for (const Set& set : sets) {
      const auto errors = method.errors(method.predict(layers, set.controls), set.truth);
      std::printf("%-8s %6zu poses  %-18s mse %.2e  max %.4f  mfm %.5f\n", how, controls.size() / method.width(),
                  set.name.c_str(), errors.mse, errors.max, errors.mfm);
    }
    std::fflush(stdout);
  }

  // Squared difference of two networks a pose, summed over outputs.
  std::vector<float> squared_difference(std::span<const float> a, std::span<const float> b) const {
    std::vector<float> sums(a.size() / method.outputs());
    for (std::size_t i = 0; i < a.size(); ++i) sums[i / method.outputs()] += (a[i] - b[i]) * (a[i] - b[i]);
    return sums;
  }

  struct Set {
    std::string name;
    std::vector<float> controls, truth;
  };
  bench::QuickMethod method;
  ControlResponses responses;
  const RigSchema& schema;
  std::vector<Set> sets;
};

double correlation_of_logs(const std::vector<float>& a, const std::vector<float>& b) {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(a[i] > 0 && b[i] > 0)) continue;
    const double p = std::log(a[i]), q = std::log(b[i]);
    n += 1, x += p, y += q, xx += p * p, yy += q * q, xy += p * q;
  }
  return (n * xy - x * y) / std::sqrt((n * xx - x * x) * (n * yy - y * y));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) fail(Status::invalid_argument, "give RIG [POSES]");
  const auto source = open_source(argv[1]);
  RigEvaluator rig(*source, parallel);
  const std::size_t poses = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 4000;
  const Bench bench(rig);
  const std::size_t width = bench.method.width();
  const std::vector<float> drawn = draw_candidates(bench.schema, bench.responses, {}, 1, 4 * poses);
  const std::vector<float> drawn_residuals = bench.method.residuals_of(drawn);
  // The parts of a drawn set lie one after the other: take evenly.
  const auto evenly = [&](std::size_t count, const std::vector<float>& values) {
    const std::size_t row = values.size() / (4 * poses);
    std::vector<float> some;
    for (std::size_t i = 0; i < count; ++i) {
      const auto first = values.begin() + static_cast<std::ptrdiff_t>(i * 4 * poses / count * row);
      some.insert(some.end(), first, first + static_cast<std::ptrdiff_t>(row));
    }
    return some;
  };
  for (const std::size_t count : {poses, 2 * poses, 4 * poses})
    bench.print("drawn", evenly(count, drawn), evenly(count, drawn_residuals));

  const std::size_t first = poses / 4;
  std::vector<float> controls = evenly(first, drawn), residuals = evenly(first, drawn_residuals);
  for (std::uint64_t round = 0; round < 3; ++round) {
    const auto one = bench.train(controls, residuals, 11), other = bench.train(controls, residuals, 12);
    const auto variance = [&](std::span<const float> some, std::size_t) {
      return bench.squared_difference(bench.method.predict(one, some), bench.method.predict(other, some));
    };
    const Bench::Set& mix = bench.sets[0];
    std::printf("round %llu: correlation of log variance with log squared error %.3f\n",
                static_cast<unsigned long long>(round),
                correlation_of_logs(variance(mix.controls, 0),
                                    bench.squared_difference(bench.method.predict(one, mix.controls), mix.truth)));
    std::fflush(stdout);
    const std::vector<float> pool = draw_candidates(bench.schema, bench.responses, {}, 100 + round, 6 * first);
    for (const std::uint32_t pose :
         select_poses(bench.schema, pool, first, ActiveSamplingOptions().random_share, variance, round)) {
      const auto at = pool.begin() + static_cast<std::ptrdiff_t>(pose * width);
      controls.insert(controls.end(), at, at + static_cast<std::ptrdiff_t>(width));
    }
    residuals = bench.method.residuals_of(controls);
  }
  bench.print("chosen", controls, residuals);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
