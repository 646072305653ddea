// What each control of a rig moves: alone, among others, and together with one to three others.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/rig/pose_set.h"
#include "bake/rig/rig_evaluator.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

struct AnalysisOptions {
  // Largest error of activation curves, and of correctives, over the diagonal.
  double curve_tolerance = 1e-4;
  double corrective_tolerance = 1e-4;
  std::uint32_t max_knots = 8;      // on either side of rest
  // Correctives of two, and of three controls, the strongest first, and a quarter as many of four. Of a live rig with
  // driven joints there may be `joint_factor` times as many, as long as no more than these move the surface itself: the
  // others are a few numbers each.
  std::uint32_t max_pairs = 1600, max_triples = 400, joint_factor = 4;
  std::uint64_t rig_budget = 0;     // poses requested of the rig at most; 0: no limit
  std::uint64_t seed = 1;
};

// What two to four controls move together beyond what they move in smaller groups.
struct Corrective {
  std::vector<std::uint32_t> controls;  // ascending
  double energy = 0;                    // sum over vertices of squared distance to the base without it, over D^2
  std::vector<std::uint32_t> features;  // its products and minima, in SparseBlendshapes::features
};

struct RigAnalysis {
  SparseBlendshapes base;               // activation curves of all controls, and correctives
  std::vector<Corrective> correctives;  // strongest first
  // controls x vertices: the largest distance over D by which a control moves a vertex between its rest value and
  // elsewhere, alone or among many others: the locality of the rig.
  std::vector<float> motion;
  // controls x vertices: the root mean square of the same over dense poses, of rig minus base; 0 where the base holds
  // all that the control moves.
  std::vector<float> residual_motion;
  std::uint64_t rig_calls = 0;        // poses requested of the rig, cached ones included
  std::uint32_t linear_controls = 0;  // controls of a single shape
  double curve_error = 0;             // largest distance of curves from the rig over D, at positions not fitted
};

// Whether an analysis with so many rig calls (0: no limit) is worth more than as many recorded poses: at least 60 for
// each control. With 33 on a rig of 303 controls, single controls took all of them, and nothing else was learnt.
inline bool pays_to_analyse(const RigSchema& schema, std::uint64_t rig_budget) {
  return rig_budget == 0 || rig_budget >= 60 * std::uint64_t(schema.control_count());
}

// Evaluates a live rig. Same rig, same options, same result for any number of threads.
RigAnalysis analyse_rig(RigEvaluator& rig, const AnalysisOptions& options, Progress& progress);

// The same fitted to recorded poses by regularised least squares: exact where a control was recorded alone, an estimate
// elsewhere. Finds no correctives of more than two controls. rig_calls is 0.
RigAnalysis analyse_poses(const PoseSet& poses, const AnalysisOptions& options, const Parallel& parallel,
                          Progress& progress);

// Keeps those correctives that lower the error most for the bytes a pose reads of them, until an average pose reads
// `bytes` (3 a vertex of every active shape). The energy of the others is added to residual_motion, so that networks
// learn it; their features stay, and what they add to numbers of driven joints, which takes few bytes. `controls`:
// typical poses, poses x controls. Returns the number of correctives of which something was dropped.
std::size_t prune_correctives(RigAnalysis& analysis, const RigSchema& schema, std::span<const float> controls,
                              const Mesh& rest, double bytes);

}  // namespace fb::bake
