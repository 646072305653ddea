// The runtime's interface: a model ready for evaluation. core/archive/EVALUATION.md defines what is computed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "model/packed_model.h"
#include "runtime/evaluation_layout.h"
#include "runtime/instruction_set.h"
#include "runtime/pose_execution.h"
#include "runtime/vertex_output.h"
#include "runtime/workspace.h"

namespace fb::runtime {

// A buffer for a vertex attribute of a batch: pose p begins at first + p * pose_stride numbers, vertex v of it another
// v * vertex_stride further. The gaps between vertices are not written.
struct BatchOutput {
  void* first = nullptr;          // floats or halves; null: no output
  std::size_t size = 0;           // of the buffer, in numbers
  std::size_t pose_stride = 0;    // 0: vertex_stride * vertices
  std::size_t vertex_stride = 0;  // >= 3; 0: 3
};

// A buffer for floats that a pose has beside vertices: those of pose p begin at first + p * pose_stride.
struct PoseFloats {
  float* first = nullptr;       // null: no output
  std::size_t size = 0;         // of the buffer, in floats
  std::size_t pose_stride = 0;  // 0: as many as a pose has
};

// A buffer for expected errors: those of pose p begin at first + p * pose_stride, the whole face before its regions.
struct ErrorOutput {
  float* first = nullptr;            // null: no output
  std::size_t size = 0;              // of the buffer, in floats
  std::size_t pose_stride = 0;       // 0: Evaluator::error_count()
  std::uint32_t* outside = nullptr;  // one a pose, see ErrorPrediction::run; null: no output
};

struct Batch {
  std::size_t poses = 0;
  std::span<const float> controls;
  std::size_t control_stride = 0;                      // between poses, in floats; 0: the number of controls
  BatchOutput positions, normals = {}, tangents = {};  // tangents: only of faces with texture coordinates
  VertexOrder order = VertexOrder::source;
  NumberFormat format = NumberFormat::float32;
  PoseMasks masks = {};
  PoseFloats sockets = {};   // 12 a socket
  PoseFloats channels = {};  // one a channel
  ErrorOutput errors = {};
  bool displacements = false;  // positions: less the rest positions, before driven joints move them
  bool unskinned = false;      // positions, normals, tangents: before driven joints move vertices
  PoseFloats joints = {};      // frames of driven joints, 12 each
  PoseFloats bounds = {};      // 6 a pose, see PoseOutput::bounds
  // Whether workers share poses where there are more of them than poses, of faces of spread_vertices or more.
  bool spread = false;
};

// Poses of which a host computes positions by itself, see fb_quantised_desc.
struct QuantisedBatch {
  std::size_t poses = 0;
  std::span<const float> controls;
  std::size_t control_stride = 0;     // as of Batch
  std::int16_t* quantised = nullptr;  // null: no output
  std::size_t quantised_size = 0;     // of the buffer, in numbers
  std::size_t quantised_stride = 0;   // between poses; 0: Evaluator::digit_column_count()
  PoseFloats steps = {};              // one a row block of the surface
  PoseFloats exact_weights = {};      // one an exact pose
  PoseFloats joints = {};             // as of Batch
};
inline constexpr std::size_t spread_vertices = 50'000;

// Evaluates poses of one model. Immutable: any number of threads may evaluate at once, each with its own Workspace.
// Evaluating allocates nothing, takes no locks, calls no libm and has a fixed order of operations: the same controls
// give the same bits on every machine, alone or in a batch, with any strides and on any thread. Controls at rest give
// the rest mesh exactly.
class Evaluator {
 public:
  // Lays out a model that check() accepts, such as one of read_archive(). See EvaluationLayout for memory and failures.
  explicit Evaluator(const PackedModel& model, const EvaluationMemory& memory = {},
                     const PoseKernels& kernels = choose_kernels())
      : layout_(model, memory, kernels) {}

  const EvaluationLayout& layout() const { return layout_; }
  const RigSchema& schema() const { return layout_.schema; }
  const PoseKernels& kernels() const { return layout_.kernels; }
  std::size_t control_count() const { return layout_.features.control_count(); }
  std::size_t coefficient_count() const { return layout_.coefficient_count; }
  std::size_t vertex_count() const { return layout_.vertex_count(); }
  std::span<const float> rest_positions() const { return std::span(layout_.rest_positions).first(3 * vertex_count()); }
  std::uint64_t bytes() const { return layout_.memory.bytes(); }
  std::size_t socket_count() const { return layout_.sockets.count(); }
  std::size_t channel_count() const { return schema().channels.size(); }
  std::size_t joint_count() const { return layout_.skin.joint_count(); }
  // See ErrorPrediction.
  std::size_t error_count() const { return layout_.errors.count(); }
  std::span<const std::uint32_t> error_regions() const { return layout_.errors.vertex_regions(); }
  // Levels of detail, with the whole, number 0.
  std::size_t level_count() const { return layout_.details.levels.size() + 1; }
  // Vertices of a level: the first so many in baked order.
  std::uint32_t level_vertices(std::size_t level) const {
    return layout_.details.vertices_at(level, layout_.meshes.surface_vertices);
  }
  std::size_t mesh_count() const { return layout_.meshes.count(); }
  // Takes the regions that move no vertex of these meshes out of a mask of regions, which is not empty. `channels`:
  // whether channels are evaluated.
  void leave_out_idle_regions(MeshMask meshes, bool channels, std::span<std::uint8_t> regions) const;
  const std::vector<std::string>& region_names() const { return layout_.region_names; }
  // Those of the surface.
  std::span<const RowBlockMatrix> row_blocks() const {
    return std::span(layout_.row_blocks).first(layout_.surface_blocks());
  }
  // See Basis::order.
  std::span<const std::uint32_t> order() const { return layout_.order; }
  // See VertexTangents::signs.
  std::span<const float> tangent_signs() const { return layout_.tangents.signs(); }

  // One pose: control_count() floats in control order, clamped to their ranges. Vertex v goes to positions + v *
  // vertex_stride. Fails with not_finite, naming the control, on NaN, before anything is written.
  void evaluate(const float* controls, float* positions, Workspace& workspace, std::size_t vertex_stride = 3) const;

  // One pose with its channels, as a bake measures it: 3 floats for each vertex of the model's mesh, those that carry
  // numbers last. unskinned: before driven joints move vertices. Otherwise like evaluate.
  void evaluate_points(const float* controls, float* points, Workspace& workspace, bool unskinned = false) const;
  std::size_t point_count() const { return layout_.meshes.vertices; }
  std::span<const float> rest_points() const { return layout_.rest_positions; }

  // The weights of the basis columns: coefficient_count() floats, all 0 at rest. NaN as above.
  void coefficients(const float* controls, float* coefficients, Workspace& workspace, RegionMask regions = {}) const;

  // The expected errors of a pose alone, error_count() floats, and how many controls are outside of what was trained;
  // see ErrorPrediction::run. Fails with invalid_argument if they are not known. NaN as above.
  void expected_errors(const float* controls, float* errors, std::uint32_t* outside, Workspace& workspace) const;

  // Many poses, on up to min(worker_count(parallel), workspaces.size()) workers. Before anything is written, fails with
  // invalid_argument if a buffer is too small, poses overlap or the model has no tangents, with not_finite on NaN,
  // naming pose and control.
  void evaluate_batch(const Batch& batch, std::span<Workspace> workspaces, const Parallel& parallel = {}) const;
  // Columns of digits of all row blocks of the surface.
  std::size_t digit_column_count() const;
  // Quantised inputs of many poses, one after the other or in blocks. Fails like evaluate_batch.
  void evaluate_quantised(const QuantisedBatch& batch, Workspace& workspace) const;
  // The first control that is NaN, or control_count().
  std::size_t find_nan(const float* controls) const;

 private:
  class BatchPoses;
  void evaluate_spread(const Batch& batch, std::span<Workspace> workspaces, const Parallel& parallel) const;
  void check_batch(const Batch& batch) const;
  void check_controls(std::span<const float> controls, std::size_t control_stride, std::size_t poses) const;
  void check_errors(const Batch& batch) const;
  std::size_t check_detail(const Batch& batch) const;
  void refuse_nan(const float* controls) const;

  const EvaluationLayout layout_;
};

}  // namespace fb::runtime
