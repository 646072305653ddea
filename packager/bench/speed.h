// How long poses take, beside the same work in Eigen and what memory bandwidth allows.
#pragma once

#include <cstddef>
#include <facebaker/facebaker_bake.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"

namespace fb::tool {

// Microseconds of processor time a pose.
struct SpeedLine {
  std::string name;
  double least, median, p99;
  double bytes;  // of the model read a pose, or moved; 0: not known
};

struct Speed {
  std::string processor, compiler, flags, instruction_set, eigen;
  double load = 0;  // microseconds from the archive's bytes in memory to a model that can be posed, checksums included
  std::vector<SpeedLine> lines;

  const SpeedLine& line(const std::string& name) const;
};

struct SpeedOptions {
  std::size_t rounds = 9;  // over all poses; within a round, methods take turns
  std::size_t cold = 40;   // poses evaluated with cold caches
  std::size_t batch = 256;
};

// On the calling thread. controls: poses x controls, in the order they are evaluated. Fails if there is no pose.
Speed measure_speed(const facebaker::Archive& archive, std::span<const float> controls, const SpeedOptions& options,
                    Progress& progress);

}  // namespace fb::tool
