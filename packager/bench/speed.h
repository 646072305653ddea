// How long poses take, beside the same work in Eigen and what memory bandwidth allows.
#pragma once

#include <cstddef>
#include <facebaker/facebaker_bake.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "bench/counted_memory.h"

namespace fb::tool {

// Microseconds a pose.
struct SpeedLine {
  std::string name;
  double least, median, p99;
  double bytes;           // of the model read a pose, or moved; 0: not known
  double spread;          // between rounds, see spread_between_rounds
  bool elapsed;           // time that passed, of several threads; else processor time
  double processors = 0;  // where elapsed: how many the threads had on average; 0: not known
  double bound = 0;       // microseconds that reading `bytes` and writing the results take alone; 0: not known
};

// What others on the machine did to a run.
struct Noise {
  std::string line;   // the one whose rounds differ most, of warm poses
  double spread = 0;  // of that line
  double waited = 0;  // share of the time in which the measuring thread did not run

  // Beyond a tenth of spread or a twentieth of waiting, figures of two runs differ by more than versions do.
  bool believable() const { return spread <= 0.1 && waited <= 0.05; }
};

// The face as sparse morph targets, see SparseShapes.
struct MorphFigures {
  std::size_t shapes = 0, correctives = 0, bytes = 0;
  double error = 0;  // root mean square over the diagonal, against the baked face
};

struct Speed {
  std::string processor, compiler, flags, instruction_set, eigen;
  double load = 0;  // microseconds from the archive's bytes in memory to a model that can be posed, checksums included
  Noise noise;
  ScratchBytes scratch;
  MorphFigures morphs;
  std::vector<SpeedLine> lines;

  const SpeedLine& line(const std::string& name) const;
};

struct SpeedOptions {
  std::size_t rounds = 9;  // over all poses; within a round, methods take turns
  std::size_t cold = 40;   // poses evaluated with cold caches
  std::size_t batch = 256;
  std::size_t crowd = 8;  // faces
  std::size_t instances = 100;  // of one face, posed together; 0: not measured
};

// On the calling thread. controls: poses x controls, in the order they are evaluated. Fails if there is no pose.
Speed measure_speed(const facebaker::Archive& archive, std::span<const float> controls, const SpeedOptions& options,
                    Progress& progress);

}  // namespace fb::tool
