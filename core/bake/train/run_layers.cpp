#include <algorithm>
#include <numeric>

#include "bake/train/dense_pass.h"
#include "base/status.h"

namespace fb::bake {

std::vector<float> run_layers(const std::vector<DenseLayer>& layers, const TrainingSet& set, const Parallel& parallel) {
  check_features(set);
  if (layers.empty() || layers.front().inputs != set.inputs || layers.back().outputs != set.outputs)
    fail(Status::invalid_argument, "running layers: they do not take %zu inputs to %zu outputs", set.inputs,
         set.outputs);
  const NetShape shape(layers);
  const std::vector<float> parameters = parameters_of(shape, layers);
  std::vector<DensePass> passes(worker_count(parallel), DensePass(shape));
  std::vector<float> outputs(set.poses * set.outputs);
  constexpr std::size_t microbatch = DensePass::most_poses;
  parallel_for(parallel, (set.poses + microbatch - 1) / microbatch, [&](std::size_t p, std::size_t worker) {
    std::vector<std::uint32_t> poses(std::min(microbatch, set.poses - p * microbatch));
    std::iota(poses.begin(), poses.end(), static_cast<std::uint32_t>(p * microbatch));
    std::ranges::copy(passes[worker].run(set, poses, parameters.data()),
                      outputs.begin() + p * microbatch * set.outputs);
  });
  return outputs;
}

}  // namespace fb::bake
