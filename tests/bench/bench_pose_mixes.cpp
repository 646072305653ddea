// Which mix of poses serves unseen shots best, by a quick method: bench_pose_mixes RIG POSES [MIX...]
// The target is the rig's own shots of the split train, on which nothing is trained here; a rig without shots is
// measured on random poses and synthetic shots of another seed. Test clips are not looked at.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "bake/dataset/open_source.h"
#include "bake/sampling/coverage.h"
#include "bake/sampling/sampling.h"
#include "quick_method.h"

using namespace fb;
using namespace fb::bake;

int main(int argc, char** argv) try {
  if (argc < 3) fail(Status::invalid_argument, "give RIG POSES [MIX...]");
  const Parallel parallel{1};
  const auto source = open_source(argv[1]);
  RigEvaluator rig(*source, parallel);
  const RigSchema& schema = rig.schema();
  const bench::QuickMethod method(rig, 200);
  std::vector<Clip> targets;
  for (const Clip& clip : rig.clips())
    if (clip.split == Split::train && clip.kind == ClipKind::shot) targets.push_back(clip);
  if (targets.empty()) targets = make_test_poses(schema, 4711);
  std::vector<std::vector<float>> truths;
  std::vector<float> target_controls;
  for (const Clip& clip : targets) {
    truths.push_back(method.residuals_of(clip.controls));
    target_controls.insert(target_controls.end(), clip.controls.begin(), clip.controls.end());
    std::printf("%-20s %5zu frames  single curves: mse %.2e  mfm %.5f\n", clip.name.c_str(), clip.frames,
                method.errors({}, truths.back()).mse, method.errors({}, truths.back()).mfm);
  }
  const std::uint64_t seeds = std::getenv("SEEDS") ? std::strtoull(std::getenv("SEEDS"), nullptr, 10) : 1;
  for (int m = 3; m < argc; ++m) {
    std::vector<bench::QuickErrors> sums(targets.size());
    double seconds = 0;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      SamplingOptions options;
      options.poses = std::strtoull(argv[2], nullptr, 10);
      options.mix = argv[m];
      options.seed = seed;
      options.shots = options.test_poses = false;
      std::vector<float> controls;
      for (const Clip& clip : make_plan(rig, options, silent_progress()))
        controls.insert(controls.end(), clip.controls.begin(), clip.controls.end());
      if (seed == 1)
        std::printf(
            "\n%s: %s", argv[m],
            coverage_text(measure_coverage(schema, control_groups(schema), controls, target_controls, parallel), schema)
                .c_str());
      const auto start = std::chrono::steady_clock::now();
      TrainingPlan plan;
      plan.widths = {192, 192, 192};
      plan.learning_rate = 2e-3f;
      plan.epochs = 80;
      plan.seed = seed;
      plan.parallel = parallel;
      const auto layers = method.train(controls, method.residuals_of(controls), plan);
      seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      for (std::size_t y = 0; y < targets.size(); ++y) {
        const auto errors = method.errors(method.predict(layers, targets[y].controls), truths[y]);
        sums[y].mse += errors.mse / static_cast<double>(seeds);
        sums[y].mfm += errors.mfm / static_cast<double>(seeds);
        sums[y].max += errors.max / static_cast<double>(seeds);
      }
    }
    for (std::size_t y = 0; y < targets.size(); ++y)
      std::printf("%-12s %-20s mse %.2e  max %.4f  mfm %.5f  (%.0f s)\n", argv[m], targets[y].name.c_str(), sums[y].mse,
                  sums[y].max, sums[y].mfm, seconds);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
