#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <optional>
#include <vector>

#include "runtime/driven_skin.h"
#include "runtime/error_prediction.h"
#include "runtime/evaluation_layout.h"
#include "runtime/exact_blend.h"
#include "runtime/feature_graph.h"
#include "runtime/polygon_graph.h"
#include "runtime/quantise.h"

namespace fb::runtime {

class Evaluator;

// Working memory of one worker, for a block of poses. It fits the evaluator it was made for, and does
// not refer to it.
class Workspace {
 public:
  // poses: poses_per_block, or 1 for a workspace that evaluates batches pose after pose and is much smaller.
  explicit Workspace(const Evaluator& evaluator, std::size_t poses = poses_per_block,
                     std::pmr::memory_resource& memory = *std::pmr::get_default_resource());

  // Control values that the last evaluation clamped; after a batch, in all poses of this worker.
  std::uint64_t clamped() const { return clamped_; }

 private:
  friend class Evaluator;
  friend class PoseExecution;
  Workspace(const EvaluationLayout& layout, std::size_t poses, std::pmr::memory_resource& memory);

  // An input list, see EvaluationLayout. Poses are interleaved.
  MatrixInputs list(const EvaluationLayout& layout, std::size_t number, std::size_t poses) {
    const std::uint32_t first = layout.list_offsets[number];
    return {list_values_.data() + first * poses, list_ends_[number] - first, 0, list_columns_.data() + first};
  }

  std::size_t block_;  // poses that are evaluated together, at most
  FeatureState features_;
  std::pmr::vector<float> list_values_;
  std::pmr::vector<std::uint32_t> list_columns_, list_ends_;
  std::pmr::vector<std::int16_t> quantised_;       // inputs of the row blocks of a pass
  std::pmr::vector<std::uint8_t> active_regions_;  // by region: whether its coefficients differ from 0 in any pose
  std::pmr::vector<float> coefficients_;           // poses interleaved
  std::pmr::vector<float> layers_;                 // pose after pose
  // Positions in the order of rows, pose after pose, row_stride() apart. Row blocks without a mark in moved_ are at
  // rest.
  std::pmr::vector<float> rows_;
  std::pmr::vector<float> block_rows_;      // of one row block, pose after pose, that need not be kept
  std::pmr::vector<std::uint8_t> moved_;    // by pose and row block
  std::pmr::vector<std::uint16_t> halves_;  // see VertexWriter
  QuantiseBuffers layer_inputs_;
  PolygonGraph::State normals_;
  std::optional<PolygonGraph::State> tangents_;  // of faces that have texture coordinates
  ErrorPrediction::State errors_;
  ExactBlend::State exact_;
  DrivenSkin::State skin_;
  // Of faces with levels of detail: of the polygons of the next level, and blended with it, in baked order.
  std::optional<PolygonGraph::State> next_normals_, next_tangents_;
  std::pmr::vector<float> detail_normals_, detail_tangents_;
  std::uint64_t clamped_ = 0;
};

}  // namespace fb::runtime
