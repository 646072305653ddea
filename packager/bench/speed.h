// How long poses take, beside what else could compute them and what memory allows.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "model/packed_model.h"

namespace fb::tool {

// Microseconds of processor time a pose.
struct SpeedLine {
  std::string name;
  double least, median, p99;
  double bytes;  // read of a model a pose, or moved; 0: not told
};

struct Speed {
  std::string processor, compiler, flags, instruction_set, eigen;
  double load = 0;  // microseconds from the archive's bytes in memory to a model that can be posed, checksums included
  std::vector<SpeedLine> lines;

  const SpeedLine& line(const std::string& name) const;
};

struct SpeedOptions {
  std::size_t rounds = 9;  // through all poses, methods taking turns
  std::size_t cold = 40;   // poses measured cold
  std::size_t batch = 256;
};

// On the calling thread. controls: poses one after the other, in the order they are to be posed. Fails on none.
Speed measure_speed(std::span<const std::byte> archive, std::span<const float> controls, const SpeedOptions& options,
                    Progress& progress);

}  // namespace fb::tool
