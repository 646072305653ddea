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

// One recipe baked for one use: a column of the paper's Table 1.
struct MethodReport {
  std::string name;  // "linear", "paper"
  Use use = Use::variant;
  EvalReport independent;   // on clips of the split test, with quality
  Errors dependency;        // on training poses (at most 4,000, evenly spaced)
  std::uint64_t bytes = 0;  // of the archive
  std::size_t parameters = 0, coefficients = 0, poses = 0;
  double train_seconds = 0;
  std::vector<std::byte> archive;
  BakeStats stats;
  std::optional<Locality> locality;  // of a live rig within its budget, or of a recording with single poses
};

// A method that could not be baked or measured.
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
  std::optional<Repeatability> repeatability = {};  // of a live rig, where its budget allowed for it
  // The dataset sampled from a live rig, with the clips measured on; null where they are the source's own.
  std::unique_ptr<Source> recorded;
  EvaluationCounts counts = {};  // what a live rig was asked, by all methods together
};

// Bakes every method on the same poses and measures the packed archives on the same clips. A live rig is sampled once;
// one without test clips is tested on held-out random poses and synthetic shots. Fails with bad_data on a recording
// without a test split. A method that fails is noted and the others are compared; its error is thrown if all fail.
// Archives stay in the work folder and are not baked again (cached_bake); they are always measured.
CompareReport compare(Source& source, const std::vector<std::string>& methods, const BakeOptions& options,
                      Progress& progress);

}  // namespace fb::bake
