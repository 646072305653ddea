// From controls to positions. An Evaluator is a face model laid out for speed; a Workspace is what one pose at a time
// needs besides. See core/archive/FORMAT.md for what is computed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <optional>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "model/packed_model.h"
#include "runtime/metered_memory.h"
#include "runtime/panel_matrix.h"

namespace fb {

class Evaluator;

// Working memory of one worker, from `memory`. Fits the evaluator it was made for, which it does not refer to.
class Workspace {
 public:
  explicit Workspace(const Evaluator& evaluator, std::pmr::memory_resource& memory = *std::pmr::get_default_resource());

  // Control values the last evaluation in this workspace clamped; after a batch, of all poses this worker did.
  std::uint64_t clamped() const { return clamped_; }

 private:
  friend class Evaluator;
  std::pmr::vector<float> controls_, features_, coefficients_, layer_input_, layer_output_, summands_, rows_;
  std::pmr::vector<ActiveColumn> active_;
  std::uint64_t clamped_ = 0, poses_ = 0;
};

// Where the poses of a batch are and where their positions go; strides in floats. Vertex v of pose p begins at
// positions[p * pose_stride + v * vertex_stride]; what lies between vertices is not touched.
struct Batch {
  std::size_t poses = 0;
  std::span<const float> controls;
  std::size_t control_stride = 0;  // 0: the number of controls
  std::span<float> positions;
  std::size_t pose_stride = 0;    // 0: vertex_stride x vertices
  std::size_t vertex_stride = 0;  // >= 3; 0: 3
};

// Immutable once built: any number of threads may evaluate at once, each with its own Workspace. Evaluating takes no
// memory and no locks, calls no libm and keeps one order of operations: the same controls give the same bits on every
// machine, alone, in a batch, with strides and on any thread, and controls at rest give the rest mesh exactly.
class Evaluator {
 public:
  // Checks the model, then lays it out in blocks from `memory`, which must outlive the evaluator; `model` is not needed
  // any more. Fails with limit if the blocks take more than max_bytes, with not_finite if the network overflows at
  // rest.
  explicit Evaluator(const PackedModel& model, std::pmr::memory_resource& memory = *std::pmr::get_default_resource(),
                     std::uint64_t max_bytes = UINT64_MAX);
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  const RigSchema& schema() const { return schema_; }
  std::size_t control_count() const { return ranges_.size(); }
  std::size_t coefficient_count() const { return coefficient_count_; }
  std::size_t vertex_count() const { return rest_.size() / 3; }
  std::span<const float> rest_positions() const { return rest_; }
  std::uint64_t bytes() const { return memory_.bytes(); }

  // One pose: control_count() floats in control order, clamped to their ranges. Vertex v goes to positions + v *
  // vertex_stride. Fails with not_finite by control on NaN, before anything is written.
  void evaluate(const float* controls, float* positions, Workspace& workspace, std::size_t vertex_stride = 3) const;

  // The weights of the basis' columns: coefficient_count() floats, all 0 at rest. NaN as above.
  void coefficients(const float* controls, float* coefficients, Workspace& workspace) const;

  // Many poses, on up to min(worker_count(parallel), workspaces.size()) workers. Before anything is written, fails with
  // invalid_argument if a buffer is too small or poses overlap, with not_finite by pose and control on NaN.
  void evaluate_batch(const Batch& batch, std::span<Workspace> workspaces, const Parallel& parallel = {}) const;

 private:
  friend class Workspace;
  struct Range {
    float minimum, maximum;
  };
  struct Layer {
    Layer(const PackedLayer& layer, std::pmr::memory_resource& memory);
    std::uint32_t inputs, outputs;
    Activation activation;
    bool skip;
    PanelMatrix low;
    std::optional<PanelMatrix> high;  // the other digits of a wide layer
    float limit;
    std::pmr::vector<float> scales, bias;
  };
  struct Net {
    Net(const PackedRegion& region, std::pmr::memory_resource& memory);
    std::pmr::vector<std::uint32_t> features, gate;
    float slope;
    std::pmr::vector<Layer> layers;
    std::pmr::vector<float> at_rest;  // what the last layer gives there
  };
  // A row group. Summand s is coefficient columns[s] times scales[s]; a wide column has two, one for each digit.
  struct Chunk {
    Chunk(const PackedRowGroup& group, std::pmr::memory_resource& memory);
    std::uint32_t first_row;
    std::pmr::vector<std::uint32_t> columns;
    std::pmr::vector<float> scales;
    PanelMatrix digits;
  };

  // The arithmetic, under a FloatState the caller holds.
  void clamp(const float* controls, Workspace& workspace) const;
  static void run_layer(const Layer& layer, Workspace& workspace);
  // Runs the layers on workspace.layer_input_, where the result is too.
  static void run_layers(const Net& net, Workspace& workspace);
  static void run_net(const Net& net, Workspace& workspace, float* coefficients);
  void run_coefficients(const float* controls, Workspace& workspace) const;
  // Adds what the coefficients move to the rest positions of the chunk's rows.
  static void run_chunk(const Chunk& chunk, Workspace& workspace, const float* rest, float* positions);
  void run_pose(const float* controls, float* positions, std::size_t vertex_stride, Workspace& workspace) const;

  // The first control that is NaN, or control_count().
  std::size_t find_nan(const float* controls) const;
  void refuse_nan(const float* controls) const;

  RigSchema schema_;
  MeteredMemory memory_;
  std::pmr::vector<Range> ranges_;
  std::pmr::vector<float> rest_controls_, rest_;
  std::pmr::vector<Feature> features_;
  std::pmr::vector<std::uint32_t> direct_;
  std::pmr::vector<Net> nets_;
  std::pmr::vector<Chunk> chunks_;
  std::pmr::vector<std::uint32_t> order_;  // empty: rows are in the order of vertices
  std::pmr::vector<float> rest_rows_;      // rest_ in the order of rows; empty where that is the same
  std::size_t coefficient_count_, widest_layer_ = 0, longest_list_ = 0;
};

}  // namespace fb
