// What an analysis of recorded poses is computed from: their residuals, regression to features, correlated pairs.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "model/rig_schema.h"

namespace fb::bake {

constexpr std::size_t recorded_poses_in_memory = 128;  // whose residuals are held at once

// Some poses of a set, seen as residuals: recorded displacements minus a base. Refers to everything it is given.
struct RecordedPoses {
  const PoseSet* poses;
  std::span<const float> controls;      // of all poses of the set
  std::span<const float> rest;          // pose
  std::span<const std::size_t> picked;  // poses of the set, ascending
  const SparseBlendshapes* base;

  std::span<const float> pose(std::size_t i) const { return controls.subspan(picked[i] * rest.size(), rest.size()); }
  // Residuals of picked poses [first, first + count): count x 3 x vertices.
  void read(std::size_t first, std::size_t count, std::span<float> residuals, const Parallel& parallel) const;
};

// The normal equations of a regression: columns are the carriers' values in all poses.
struct NormalEquations {
  Eigen::MatrixXd gram;         // columns x columns
  std::vector<float> products;  // column-major: coordinates x columns
  std::vector<double> squares;  // of each coordinate, summed over poses
};

// Least squares of residuals, regularised as strongly as is asked for: the poses are read once.
class Regression {
 public:
  // To approximate the residuals by shapes of `features[carriers[k]]`.
  Regression(const RecordedPoses& recorded, std::span<const Feature> features, std::vector<std::uint32_t> carriers,
             std::vector<double> ridge, const Parallel& parallel, Progress& progress);

  // One shape a carrier, with `strength` x ridge[k] times the mean square of all carriers added to the diagonal; none
  // if all carriers are 0 in all poses. Offsets within four standard errors of 0 are dropped: noise would otherwise
  // move every vertex.
  std::vector<SparseShape> shapes(double strength, const Parallel& parallel) const;

 private:
  std::vector<std::uint32_t> carriers_;
  std::vector<double> ridge_;
  std::size_t poses_;
  NormalEquations equations_;
};

using ControlPair = std::pair<std::uint32_t, std::uint32_t>;

// At most `most` pairs of controls whose product correlates with the residuals more than by chance, strongest first;
// features[c] is the factor of control c. Found a few at a time, each time in what the pairs before leave unexplained.
// Works on a random projection of the residuals (Johnson, Lindenstrauss, Contemp. Math. 26, 1984) drawn from the seed.
std::vector<ControlPair> correlated_pairs(const RecordedPoses& recorded, std::span<const Feature> features,
                                          std::size_t most, std::uint64_t seed, const Parallel& parallel,
                                          Progress& progress);

// Controls x vertices, over D: the largest distance by which parts of a base move each vertex with each of their
// controls, the other controls of the part at the ends of their ranges.
std::vector<float> part_motion(const RigSchema& schema, std::span<const SparseBlendshapes* const> parts,
                               std::size_t vertices, double diagonal, const Parallel& parallel);

// Controls x vertices, over D: by how much the root mean square residual of a vertex is larger in poses with the
// control active than in the others; 0 where `motion` says that the control does not move the vertex, and where the
// difference may be chance.
std::vector<float> residual_by_control(const RecordedPoses& recorded, std::span<const float> motion, double diagonal,
                                       const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
