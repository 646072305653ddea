#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/measure/evaluate.h"
#include "bake/measure/locality.h"
#include "bake/pipeline/bake.h"

namespace fb::bake {

// One method on one use: a column of the paper's Table 1.
struct MethodReport {
  std::string name;  // "linear", "paper"
  Use use = Use::variant;
  EvalReport independent;   // unseen: clips of the split test, with quality
  Errors dependency;        // data it was trained on (at most 4,000 frames, evenly spaced)
  std::uint64_t bytes = 0;  // of the archive
  std::size_t parameters = 0, coefficients = 0, poses = 0;
  double train_seconds = 0;
  std::vector<std::byte> archive;
  BakeStats stats;
  std::optional<Locality> locality;  // where there is a live rig to ask
};

// A method that could not be baked or measured, and why.
struct MethodFailure {
  std::string name;
  Use use = Use::variant;
  std::string reason;
};

struct CompareReport {
  std::string name, units;
  double diagonal = 0;
  std::uint64_t rig_calls = 0;        // poses a live rig was asked for in this call, by all methods together
  std::vector<MethodReport> methods;  // every method as variant, then as backlot where shots to train on exist
  std::vector<MethodFailure> failures;
  // The recording of a live rig that has the clips measured on; null where they are the source's own.
  std::unique_ptr<Source> recorded;
};

// Bakes every method on the same poses and measures the packed archives on the same clips. A live rig is sampled once;
// one without test clips is tested on held-out random poses and synthetic shots. A recording without a test split is
// refused. A method that fails is noted and does not keep the others from being compared; the error is thrown if all
// fail. What is baked stays in the work folder and is not baked again; it is always measured anew.
CompareReport compare(Source& source, const std::vector<std::string>& methods, const BakeOptions& options,
                      Progress& progress);

}  // namespace fb::bake
