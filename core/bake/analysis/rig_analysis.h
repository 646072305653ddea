// Finds out what each control does: alone, in company, and in pairs and triples.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/rig/pose_set.h"
#include "bake/rig/rig_evaluator.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

struct AnalysisOptions {
  // What a curve of a single control, and then the terms of pairs and triples, may be off, over the diagonal.
  double curve_tolerance = 1e-4;
  double corrective_tolerance = 1e-4;
  std::uint32_t max_knots = 8;      // on either side of rest
  std::uint32_t max_pairs = 1600;   // interacting pairs given terms, the strongest first
  std::uint32_t max_triples = 400;  // and a quarter as many fours
  std::uint64_t rig_budget = 0;     // rig calls at most; 0: as many as it takes
  std::uint64_t seed = 1;
};

// Controls that do together what they do not do one by one.
struct Corrective {
  std::vector<std::uint32_t> controls;  // two to four, ascending
  double energy = 0;                    // sum over vertices of squared distance to the base without it, over D^2
  std::vector<std::uint32_t> features;  // the product and minimum features found for it, in SparseBlendshapes::features
};

struct RigAnalysis {
  SparseBlendshapes base;
  std::vector<Corrective> correctives;  // strongest first
  // controls x vertices: the largest distance over D that moving this control between its rest value and elsewhere
  // moves the vertex, alone or among many others: the rig's own locality.
  std::vector<float> motion;
  // The same of what the base leaves over (root mean square over the dense poses tried): 0 where a control only adds
  // what the base already holds.
  std::vector<float> residual_motion;
  std::uint64_t rig_calls = 0;        // poses requested of the rig, cached ones included
  std::uint32_t linear_controls = 0;  // controls one shape holds
  double curve_error = 0;             // largest distance from the rig between knots, over D, on poses not used
};

// Whether so many rig calls (0: any number) say more than the same poses recorded would: at least 20 a control.
inline bool pays_to_analyse(const RigSchema& schema, std::uint64_t rig_budget) {
  return rig_budget == 0 || rig_budget >= 20 * std::uint64_t(schema.control_count());
}

// Evaluates a live rig. Same rig, same options, same result for any number of threads.
RigAnalysis analyse_rig(RigEvaluator& rig, const AnalysisOptions& options, Progress& progress);

// The same fitted to recorded poses by regularised least squares, when there is no rig to ask: exact where a control
// was recorded alone, an estimate elsewhere. rig_calls is 0.
RigAnalysis analyse_poses(const PoseSet& poses, const AnalysisOptions& options, const Parallel& parallel,
                          Progress& progress);

}  // namespace fb::bake
