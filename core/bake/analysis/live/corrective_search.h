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

// Finds what controls do together beyond what the base holds, order by order: pairs, triples, ... one procedure. A
// candidate is a tuple that interacts without one of its controls, and whose controls all leave residual motion at some
// vertex. Candidates are tried at the ends of ranges, the strongest on a grid, and terms fitted to
// what is left there once the same differences of fewer controls are taken away. In the end, terms stay if they also
// bring the poses of many controls closer to the rig.
class CorrectiveSearch {
 public:
  // All must outlive it. `base` holds the curves.
  CorrectiveSearch(RigEvaluator& rig, const AnalysisOptions& options, const std::vector<ControlCurve>& curves,
                   const DenseDifferences& dense, SparseBlendshapes& base, Progress& progress);

  // Looks for tuples of `order` controls, 2 first, then 3, and adds terms for `most` of them at most to the base.
  void find(std::size_t order, std::size_t most);

  // Takes terms that do more harm than good among many controls out of the base. Returns the others, strongest first.
  std::vector<Corrective> finish();

 private:
  struct Tuple {
    std::vector<std::uint32_t> controls;
    double score = 0, energy = 0, distance = 0;
    SparseBlendshapes part;
  };
  // A point of a tuple's grid: for each control 0, rest, or the number of a telling place, from 1.
  using Point = std::vector<std::uint8_t>;

  std::vector<Tuple> candidates(std::size_t order) const;
  std::vector<Point> ends(const Tuple& tuple, bool inner) const;
  std::vector<Point> grid(const Tuple& tuple) const;
  // Differences of every tuple at its points, in blocks: visit(tuple, points, differences), several at once. What
  // `fewest` or more of its controls do alone is taken away.
  template <class Points, class Visit>
  void evaluate_tuples(const char* stage, std::span<Tuple> tuples, std::size_t fewest, const Points& points,
                       const Visit& visit);
  // Sets energy and distance at the ends of ranges; leaves those above the tolerance, strongest first.
  void rank(const char* stage, std::vector<Tuple>& tuples, std::size_t fewest);
  void fill(const Tuple& tuple, const Point& point, std::span<float> pose) const;
  void fit(Tuple& tuple, std::span<const Point> points, std::span<const std::vector<float>> differences) const;
  void note_error(const std::string& what) const;

  RigEvaluator& rig_;
  const AnalysisOptions& options_;
  const std::vector<ControlCurve>& curves_;
  const DenseDifferences& dense_;
  SparseBlendshapes& base_;
  Progress& progress_;
  std::vector<CurveErrors> curve_errors_;
  std::vector<float> single_left_;  // controls x vertices: the largest distance over D curves leave over of toggles
  HoldoutSet held_;
  std::vector<Tuple> found_;
};

}  // namespace fb::bake
