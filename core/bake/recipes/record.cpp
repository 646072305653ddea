#include "bake/recipes/record.h"

#include "bake/sampling/sampling.h"

namespace fb {

std::unique_ptr<Source> record(Source& rig, const BakeOptions& options, Recording what, Progress& progress) {
  SamplingOptions sampling;
  sampling.poses = options.poses;
  sampling.seed = options.seed;
  sampling.mix = options.mix;
  sampling.held_out = what == Recording::with_test;
  const std::filesystem::path folder = options.work / "poses";
  sample(rig, sampling, folder, options.parallel, progress);
  return open_source(folder.string());
}

}  // namespace fb
