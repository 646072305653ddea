// From controls to positions. An Evaluator is a face model laid out for speed; a Workspace is what one pose at a time
// needs besides. See core/archive/FORMAT.md for what is computed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <string>
#include <vector>

#include "base/large_pages.h"
#include "base/parallel.h"
#include "model/packed_model.h"
#include "runtime/feature_graph.h"
#include "runtime/instruction_set.h"
#include "runtime/metered_memory.h"
#include "runtime/quantized.h"
#include "runtime/region_net.h"
#include "runtime/row_block_matrix.h"
#include "runtime/vertex_normals.h"
#include "runtime/vertex_output.h"
#include "runtime/vertex_tangents.h"

namespace fb::runtime {

class Evaluator;

// Working memory of one worker, from `memory`: for a block of block_poses poses at once. Fits the evaluator it was made
// for, which it does not refer to.
class Workspace {
 public:
  explicit Workspace(const Evaluator& evaluator, std::pmr::memory_resource& memory = *std::pmr::get_default_resource());

  // Control values the last evaluation in this workspace clamped; after a batch, of all poses this worker did.
  std::uint64_t clamped() const { return clamped_; }

 private:
  friend class Evaluator;
  FeatureState features_;
  // The evaluator's lists: numbers of one pose, or of each pose of a block side by side, the places they belong to, and
  // where each list ends.
  std::pmr::vector<float> values_;
  std::pmr::vector<std::uint32_t> places_, ends_;
  std::pmr::vector<std::int16_t> quantised_;  // of some chunks' summands
  std::pmr::vector<std::uint8_t> open_;       // by region: whether it gives anything but 0 in any pose
  std::pmr::vector<float> coefficients_;      // those of poses side by side
  // Pose after pose. Rows are those at rest but for chunks that moved_ says are not.
  std::pmr::vector<float> layers_, rows_;
  std::pmr::vector<std::uint8_t> moved_;
  std::pmr::vector<std::uint16_t> halves_;
  LayerInputs layer_inputs_;
  VertexNormals::State normals_;
  VertexTangents::State tangents_;
  std::uint64_t clamped_ = 0, poses_ = 0;
};

// Which regions' networks run; the others give coefficients 0, as at rest. Empty: all; else one a region, 0 for no.
using RegionMask = std::span<const std::uint8_t>;

// Where poses go: normals and tangents need no positions to go anywhere.
struct PoseOutput {
  VertexOutput positions, normals, tangents;
};

// Where something of each pose of a batch goes: pose p's begins at first + p * pose_stride numbers, vertex v's
// v * vertex_stride further. What lies between vertices is not touched.
struct BatchOutput {
  void* first = nullptr;          // of floats or halves; null: not wanted
  std::size_t size = 0;           // of that buffer, in numbers
  std::size_t pose_stride = 0;    // 0: vertex_stride x vertices
  std::size_t vertex_stride = 0;  // >= 3; 0: 3
};

struct Batch {
  std::size_t poses = 0;
  std::span<const float> controls;
  std::size_t control_stride = 0;                      // in floats; 0: the number of controls
  BatchOutput positions, normals = {}, tangents = {};  // tangents: of faces that have texture coordinates
  VertexOrder order = VertexOrder::source;
  NumberFormat format = NumberFormat::float32;
  RegionMask regions = {};
};

// Immutable once built: any number of threads may evaluate at once, each with its own Workspace. Evaluating takes no
// memory and no locks, calls no libm and keeps one order of operations: the same controls give the same bits on every
// machine, alone, in a batch, with strides and on any thread, and controls at rest give the rest mesh exactly.
class Evaluator {
 public:
  // Lays out a model that check() accepts, as read_archive's are, in blocks from `memory`, which must outlive the
  // evaluator; null: from the default resource, or from large pages where the model fills some. `model` is not needed
  // any more. Fails with limit if the blocks take more than max_bytes, with not_finite
  // if the network overflows at rest.
  explicit Evaluator(const PackedModel& model, std::pmr::memory_resource* memory = nullptr,
                     std::uint64_t max_bytes = UINT64_MAX, const PoseKernels& kernels = choose_kernels());
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  const RigSchema& schema() const { return schema_; }
  const PoseKernels& kernels() const { return kernels_; }
  std::size_t control_count() const { return graph_.control_count(); }
  std::size_t coefficient_count() const { return coefficient_count_; }
  std::size_t vertex_count() const { return rest_.size() / 3; }
  std::span<const float> rest_positions() const { return rest_; }
  std::uint64_t bytes() const { return memory_.bytes(); }
  const std::vector<std::string>& region_names() const { return region_names_; }
  // The basis: row 3 i + axis is coordinate `axis` of vertex order()[i], or of vertex i if it is empty.
  const std::pmr::vector<RowBlockMatrix>& chunks() const { return chunks_; }
  std::span<const std::uint32_t> order() const { return order_; }
  // See VertexTangents::signs.
  std::span<const float> tangent_signs() const { return tangents_.signs(); }

  // One pose: control_count() floats in control order, clamped to their ranges. Vertex v goes to positions + v *
  // vertex_stride. Fails with not_finite by control on NaN, before anything is written.
  void evaluate(const float* controls, float* positions, Workspace& workspace, std::size_t vertex_stride = 3) const;

  // The weights of the basis' columns: coefficient_count() floats, all 0 at rest. NaN as above.
  void coefficients(const float* controls, float* coefficients, Workspace& workspace, RegionMask regions = {}) const;

  // Many poses, on up to min(worker_count(parallel), workspaces.size()) workers. Before anything is written, fails with
  // invalid_argument if a buffer is too small, poses overlap or there are no tangents, with not_finite by pose and
  // control on NaN.
  void evaluate_batch(const Batch& batch, std::span<Workspace> workspaces, const Parallel& parallel = {}) const;

 private:
  friend class Workspace;
  // What active features are used for is written to lists: the inputs of each region, then what each region's gate
  // looks at, then the summands of each chunk. Of a list, the numbers in a pose begin at first_in_list_.
  struct Use {
    std::uint32_t list, place;
    float scale;
  };
  std::size_t gate_list(std::size_t region) const { return nets_.size() + region; }
  std::size_t chunk_list(std::size_t chunk) const { return 2 * nets_.size() + chunk; }
  static constexpr std::size_t some_chunks = 16;  // see run_chunks()
  // A region's summands in a chunk.
  struct ChunkRegion {
    std::uint32_t region, begin, end;
  };

  void lay_out_lists(const PackedModel& model);
  void lay_out_uses(const PackedModel& model);
  // A list in a workspace.
  PoseNumbers numbers(std::size_t list, std::size_t poses, Workspace& workspace) const {
    const std::uint32_t first = first_in_list_[list];
    return {workspace.values_.data() + first * poses, workspace.ends_[list] - first, workspace.places_.data() + first};
  }
  // The arithmetic, under a FloatState the caller holds, of one pose or of block_poses of them at once.
  template <std::size_t poses>
  void gather_lists(Workspace& workspace) const;
  template <std::size_t poses>
  void run_regions(RegionMask regions, Workspace& workspace) const;
  template <std::size_t poses>
  void round_summands(std::size_t chunk, Workspace& workspace, std::int16_t* quantised, Quantized& summands) const;
  template <std::size_t poses>
  void run_chunks(float* const* rows, Workspace& workspace) const;
  template <std::size_t poses>
  void run_features_on(const PoseOutput* outputs, RegionMask regions, Workspace& workspace) const;
  void run_pose(const float* controls, const PoseOutput& output, RegionMask regions, Workspace& workspace) const;
  void run_block(const float* controls, std::size_t stride, const PoseOutput (&outputs)[block_poses],
                 RegionMask regions, Workspace& workspace) const;
  void run_coefficients(const float* controls, RegionMask regions, float* coefficients, Workspace& workspace) const;

  void check_batch(const Batch& batch) const;
  // The first control that is NaN, or control_count().
  std::size_t find_nan(const float* controls) const;
  void refuse_nan(const float* controls) const;

  RigSchema schema_;
  const PoseKernels& kernels_;
  LargePages pages_;
  MeteredMemory memory_;
  FeatureGraph graph_;
  std::vector<std::string> region_names_;
  std::pmr::vector<RegionNet> nets_;
  std::pmr::vector<float> slopes_;  // of the regions' gates; 0: no gate
  std::pmr::vector<RowBlockMatrix> chunks_;
  std::pmr::vector<std::uint32_t> direct_;
  std::pmr::vector<std::uint32_t> first_coefficient_;  // of regions
  std::pmr::vector<std::uint32_t> first_in_list_;      // one more than lists
  std::pmr::vector<Use> uses_;                         // feature after feature
  std::pmr::vector<std::uint32_t> uses_begin_;         // one more than features
  // What chunks use of regions, chunk after chunk.
  std::pmr::vector<ChunkRegion> chunk_regions_;
  std::pmr::vector<std::uint32_t> chunk_regions_begin_;
  std::pmr::vector<float> rest_, rest_rows_;          // in the order of vertices, and of rows
  std::pmr::vector<std::uint32_t> order_, place_of_;  // empty: rows are in the order of vertices
  VertexNormals normals_;
  VertexTangents tangents_;
  std::size_t coefficient_count_, widest_layer_ = 0, work_size_ = 0, most_summands_ = 0;
};

}  // namespace fb::runtime
