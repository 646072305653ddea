// Throughput of training: bench_training [THREADS [SECONDS [bf16]]]. For each network shape, poses a second and GFLOP/s
// by wall clock and by CPU time; on a machine with other work, compare CPU time.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string_view>
#include <utility>

#include "bake/train/trainer.h"
#include "base/random.h"
#include "base/status.h"

using namespace fb;
using namespace fb::bake;

namespace {

struct Bench {
  const char* name;
  std::vector<std::uint32_t> widths;
  std::size_t inputs;
  Activation activation;
};

}  // namespace

int main(int argc, char** argv) try {
  constexpr std::size_t poses = 4096, outputs = 100;
  const double seconds = argc > 2 ? std::atof(argv[2]) : 1;
  const std::vector<Bench> benches = {
      {"8x256 relu", std::vector<std::uint32_t>(8, 256), 100, Activation::relu},
      {"8x256 silu", std::vector<std::uint32_t>(8, 256), 100, Activation::silu},
      {"4x256 silu", std::vector<std::uint32_t>(4, 256), 100, Activation::silu},
      {"4x256 silu, 1500 inputs", std::vector<std::uint32_t>(4, 256), 1500, Activation::silu},
      {"3x128 silu", std::vector<std::uint32_t>(3, 128), 100, Activation::silu},
      {"3x64 silu", std::vector<std::uint32_t>(3, 64), 100, Activation::silu},
  };
  std::printf("%-24s %12s %12s %10s %10s\n", "network, batch 256", "poses/s", "poses/cpu s", "GFLOP/s", "GFLOP/cpu s");
  for (const Bench& bench : benches) {
    Random random(1);
    std::vector<float> features, targets;
    for (std::size_t i = 0; i < poses * bench.inputs; ++i) features.push_back(random.uniform(-1, 1));
    for (std::size_t i = 0; i < poses * outputs; ++i) targets.push_back(random.normal());
    TrainingPlan plan;
    plan.widths = bench.widths;
    plan.activation = bench.activation;
    plan.parallel.threads = argc > 1 ? std::atoi(argv[1]) : 1;
    plan.bf16 = argc > 3 && std::string_view(argv[3]) == "bf16";
    const TrainingSet set{poses, bench.inputs, outputs, features, targets};
    // Forward pass, gradient of the weights and, except in the first layer, gradient of the inputs.
    double flops = -2.0 * static_cast<double>(bench.inputs * bench.widths[0]);
    std::size_t inputs = bench.inputs;
    for (const std::uint32_t width : bench.widths)
      flops += 6.0 * static_cast<double>(std::exchange(inputs, width) * width);
    flops += 6.0 * static_cast<double>(inputs * outputs);

    // Doubles the epochs until they take long enough.
    for (plan.epochs = 1;; plan.epochs *= 2) {
      const auto start = std::chrono::steady_clock::now();
      const std::clock_t cpu_start = std::clock();
      train_layers(set, plan, silent_progress());
      const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      const double cpu = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
      if (cpu < seconds) continue;
      const double done = static_cast<double>(poses) * plan.epochs;
      std::printf("%-24s %12.0f %12.0f %10.1f %10.1f\n", bench.name, done / wall, done / cpu,
                  done * flops / wall * 1e-9, done * flops / cpu * 1e-9);
      break;
    }
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
