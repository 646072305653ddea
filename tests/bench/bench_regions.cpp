// Time, memory and truncation error of regions and local bases: bench_regions REGIONS OVERLAP COMPONENTS SOURCE...
// The sources are of one character; one is a live rig, which is analysed. The training poses of all are projected.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "bake/analysis/rig_analysis.h"
#include "bake/dataset/open_source.h"
#include "bake/regions/local_basis.h"
#include "base/status.h"

using namespace fb;
using namespace fb::bake;

namespace {

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int measure(const RegionOptions& region_options, std::size_t components, const std::vector<std::string>& names) {
  const auto source = open_sources(names);
  const PoseSet poses(*source, [](const Clip& clip) { return clip.split == Split::train; });
  const double start = seconds();
  if (!source->live()) fail(Status::invalid_argument, "none of the sources is a live rig that can be analysed");
  RigEvaluator rig(*source);
  const RigAnalysis analysis = analyse_rig(rig, {}, silent_progress());
  const double analysed = seconds();
  const std::vector<FaceRegion> regions =
      find_regions(source->rest(), source->schema(), analysis.residual_motion, region_options);
  const double found = seconds();
  const Residual residual(poses, analysis.base);
  const std::vector<LocalBasis> bases =
      local_bases(residual, regions, {.max_components = components}, {}, silent_progress());
  const double done = seconds();

  std::printf("%-24s %8s %8s %8s %5s %10s %10s\n", "region", "vertices", "controls", "energy", "K", "rms error",
              "max error");
  std::vector<char> moved(residual.rows() / 3, 0);
  std::size_t region_vertices = 0, count = 0, coefficients = 0, values = 0;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    std::printf("%-24s %8zu %8zu %7.2f%% %5zu %10.2e %10.2e\n", regions[r].name.c_str(), regions[r].vertices.size(),
                regions[r].controls.size(), 100 * regions[r].energy, bases[r].count, bases[r].rms_error,
                bases[r].max_error);
    region_vertices += regions[r].vertices.size();
    coefficients += bases[r].count;
    values += bases[r].components.size();
    for (const std::uint32_t v : regions[r].vertices) moved[v] = 1;
  }
  for (const char m : moved) count += m != 0;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "%zu poses, %zu of %zu vertices, %.3f regions a vertex, %zu coefficients, %zu values in the bases\n"
      "seconds: analysis %.2f, regions %.2f, local bases %.2f; peak memory %ld MiB\n",
      poses.size(), count, moved.size(), double(region_vertices) / double(std::max<std::size_t>(count, 1)),
      coefficients, values, analysed - start, found - analysed, done - found, usage.ru_maxrss / 1024);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr, "usage: bench_regions REGIONS OVERLAP COMPONENTS SOURCE...\n");
    return 2;
  }
  try {
    return measure({.regions = static_cast<std::uint32_t>(std::atoi(argv[1])), .overlap = std::atof(argv[2])},
                   std::strtoul(argv[3], nullptr, 10), {argv + 4, argv + argc});
  } catch (const Error& error) {
    std::fprintf(stderr, "bench_regions: %s\n", error.what());
    return 1;
  }
}
