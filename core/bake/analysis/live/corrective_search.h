#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/analysis/holdout_set.h"
#include "bake/analysis/live/excitation_curves.h"
#include "bake/analysis/live/finite_differences.h"
#include "bake/analysis/rig_analysis.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// Finds correctives of a live rig: what two, three or four controls move together beyond what the base holds. A
// candidate of order n is a corrective of order n - 1 and one more control (of order 2: any pair) whose controls all
// leave residual motion at some vertex. Candidates are ranked by what is left at the ends of ranges, the strongest are
// sampled on a grid, and products and minima of features are fitted to the differences there of the anchored expansion
// (see sparse_blendshapes.h). In the end, correctives stay that also lower the error of dense poses.
class CorrectiveSearch {
 public:
  // All must outlive it. `base` holds the curves; correctives are added to it.
  CorrectiveSearch(RigEvaluator& rig, const AnalysisOptions& options, const std::vector<ControlCurve>& curves,
                   DenseDifferences& dense, SparseBlendshapes& base, Progress& progress);

  // Adds at most `most` correctives of `order` controls that move the surface, and of driven joints alone, see
  // AnalysisOptions; 2 first, then 3, then 4.
  void find(std::size_t order, std::size_t most);

  // Adds correctives of exactly these controls (two to four each, ascending), and of those subsets of them that are
  // above the tolerance, where there are none yet. Returns how many could be fitted.
  std::size_t add(std::span<const std::vector<std::uint32_t>> missed);
  // Whether there is a corrective of exactly these controls, ascending.
  bool has(const std::vector<std::uint32_t>& controls) const;

  // A control of a corrective, and the pose in which the corrective fitted is furthest from the rig.
  struct Misfit {
    std::uint32_t control = 0;
    std::vector<float> pose;
  };
  // Every control with a corrective that is off by more than `least` at a vertex, rig units, in the worst such pose.
  std::vector<Misfit> misfits(double least) const;

  // Removes correctives from the base that raise the error of dense poses. Returns the others, strongest first.
  std::vector<Corrective> prune();

 private:
  struct Candidate {
    std::vector<std::uint32_t> controls;  // ascending
    double score = 0, energy = 0, distance = 0;
    bool surface = false;  // it moves a vertex that carries no numbers of joints by more than the tolerance
    SparseBlendshapes part;
    double misfit = 0;  // largest distance of the part from the rig at a vertex, rig units
    std::vector<float> misfit_pose;
  };
  // A point of a candidate's grid: for each control 0, at rest, or a knot position, numbered from 1.
  using GridPoint = std::vector<std::uint8_t>;
  using GridPoints = std::vector<GridPoint>;

  std::vector<std::vector<std::uint32_t>> extended_controls(std::size_t order) const;
  std::vector<Candidate> candidates(std::size_t order) const;
  GridPoints range_ends(const Candidate& candidate, bool inner) const;
  GridPoints full_grid(const Candidate& candidate) const;
  // Calls visit(candidate, points, differences) for every candidate that the budget allows for, several at once, with
  // the points of points_of(candidate) and what the rig moves there beyond the base and beyond subsets of `fewest` or
  // more of the candidate's controls.
  template <class PointsOf, class Visit>
  void evaluate_candidates(const char* stage, std::span<Candidate> candidates, std::size_t fewest,
                           const PointsOf& points_of, const Visit& visit);
  std::vector<std::vector<float>> evaluate_residuals(std::span<const Candidate> candidates,
                                                     std::span<const GridPoints> points_of_each,
                                                     EvaluationStage& stage);
  // Sets energy and distance from the ends of ranges; leaves candidates above the tolerance, strongest first.
  void rank(const char* stage, std::vector<Candidate>& candidates, std::size_t fewest);
  // The same for candidates of three or four controls, in their order, until `most` are left; the others are left out.
  // Returns how many were ranked.
  std::size_t rank_in_batches(std::vector<Candidate>& candidates, std::size_t most);
  static bool stronger(const Candidate& a, const Candidate& b) { return a.energy > b.energy; }
  // How many there may be in all, if `most` of them may move the surface: no more where most of those found do.
  std::size_t with_joints(std::size_t most) const;
  // Removes what are too many of sorted candidates.
  void limit(std::vector<Candidate>& candidates, std::size_t most) const;
  // Sets energy, distance and surface from differences at the points of its grid.
  void weigh(Candidate& candidate, std::span<const std::vector<float>> differences) const;
  // Fits the candidates, and adds those that can be fitted to the base. Returns how many.
  std::size_t fit_all(std::vector<Candidate> candidates);
  void set_pose(const Candidate& candidate, const GridPoint& point, std::span<float> pose) const;
  std::vector<std::uint32_t> composed_features(const Candidate& candidate, std::vector<Feature>& features) const;
  void fit(Candidate& candidate, std::span<const GridPoint> points,
           std::span<const std::vector<float>> differences) const;
  void note_error(const std::string& what) const;

  RigEvaluator& rig_;
  const AnalysisOptions& options_;
  const std::vector<ControlCurve>& curves_;
  const DenseDifferences& dense_;
  SparseBlendshapes& base_;
  Progress& progress_;
  std::vector<CurveErrors> curve_errors_;
  std::vector<float>
      curve_residual_motion_;  // controls x vertices, over D: the largest that curves leave in dense poses
  HoldoutSet dense_poses_;
  std::vector<Candidate> found_;
};

}  // namespace fb::bake
