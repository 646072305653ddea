#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/evaluation_layout.h"
#include "runtime/spread.h"
#include "runtime/vertex_output.h"
#include "runtime/workspace.h"

namespace fb::runtime {

// By region, 0 for those whose networks do not run; their coefficients are 0, as at rest. Empty: all run.
using RegionMask = std::span<const std::uint8_t>;

inline constexpr std::size_t bounds_floats = 6;

// The outputs of one pose.
struct PoseOutput {
  VertexOutput positions, normals, tangents;
  float* sockets = nullptr;   // frames; null: no output
  float* channels = nullptr;  // values; null: no output
  // bounds_floats of the positions of the vertices of posed meshes: the least, then the largest; null: no output
  float* bounds = nullptr;
  float* joints = nullptr;     // frames of driven joints; null: no output
  bool displacements = false;  // positions: less the rest positions
  // Positions, normals and tangents: before driven joints move vertices.
  bool unskinned = false;
  bool all_points = false;  // positions: those that carry numbers, too
};

// What a host computes positions of one pose from by itself, see fb_quantised_desc. Null: no output.
struct QuantisedOutput {
  std::int16_t* values = nullptr;  // by matrix column, row block after row block of the surface
  float* steps = nullptr;          // one each
  float* exact_weights = nullptr;  // of exact poses
  float* joints = nullptr;         // frames of driven joints
};

// What is left out of poses.
struct PoseMasks {
  RegionMask regions = {};
  MeshMask meshes = {};  // the vertices of those that are not posed are not written
  // The level of detail: 0 the whole, between whole numbers sliding from one to the next; 0 or more.
  float lod = 0;
  // Whether only the vertices of the level are written, the first in baked order, instead of all: others on its
  // surface.
  bool level_only = false;
};

// Evaluates poses of a layout in a workspace: features, input lists, networks, row blocks, output. All calls run under
// with_float_mode(), on controls without NaN. Refers to its arguments.
class PoseExecution {
 public:
  PoseExecution(const EvaluationLayout& layout, const PoseMasks& masks, Workspace& workspace)
      : PoseExecution(layout, masks, {&workspace, 1}, {}) {}
  // Of single poses, in the first workspace; each worker of `spread` has one of its own for what it does.
  PoseExecution(const EvaluationLayout& layout, const PoseMasks& masks, std::span<Workspace> workspaces,
                const Spread& spread)
      : layout_(layout),
        regions_(masks.regions),
        meshes_(masks.meshes),
        detail_(layout.details, masks.lod),
        level_only_(masks.level_only),
        workspace_(workspaces[0]),
        workspaces_(workspaces),
        spread_(spread) {}

  // One pose. Adds the number of clamped controls to the workspace, as the others do.
  void run_pose(const float* controls, const PoseOutput& output);

  // poses_per_block poses, whose controls are `stride` floats apart. Their outputs differ in addresses only.
  void run_block(const float* controls, std::size_t stride, const PoseOutput (&outputs)[poses_per_block]);

  // The quantised inputs of the surface's row blocks; of single poses, and of blocks of them like run_block.
  void run_quantised(const float* controls, const QuantisedOutput& output);
  void run_quantised_block(const float* controls, std::size_t stride,
                           const QuantisedOutput (&outputs)[poses_per_block]);

  // The coefficients of one pose.
  void run_coefficients(const float* controls, float* coefficients);

 private:
  bool find_block_features(const float* controls, std::size_t stride);
  template <std::size_t poses>
  void run_features_on(const PoseOutput* outputs);
  template <std::size_t poses, bool at_level>
  void scatter_features();
  template <std::size_t poses>
  void run_regions();
  template <std::size_t poses>
  void find_gate_values(std::size_t region, float (&gates)[poses]);
  void fade_coefficients(std::size_t region, std::size_t count, std::size_t poses);
  template <std::size_t poses>
  void run_quantised_on(const QuantisedOutput* outputs);
  template <std::size_t poses>
  void quantise_inputs(std::size_t block, std::int16_t* to, QuantisedInputs& inputs);
  // Where rows go, and from there positions.
  struct RowTarget {
    float* const* rows;                     // by pose
    bool in_workspace = false;              // whether they are those that the workspace keeps
    bool of_one_block = false;              // whether there is room for the rows of one block only
    const PoseOutput* scattered = nullptr;  // whose positions are written block by block, by pose; null: none
  };
  template <std::size_t poses>
  void run_row_blocks(const RowTarget& target);
  template <std::size_t poses>
  void run_pass(std::size_t first, std::int16_t* quantised, const RowTarget& target);
  template <std::size_t poses>
  void run_row_block(std::size_t block, const QuantisedInputs& inputs, const RowTarget& target);
  bool add_corrections(std::size_t pose, std::size_t block, const float* rest, float* rows);
  void scatter(std::size_t block, const float* rows, const PoseOutput& output);
  bool scatters(const PoseOutput& output) const;
  template <class Visit>
  void visit_written(const Visit& visit) const;
  void slide(std::size_t pose, float* rows, bool in_workspace);
  void skin(std::size_t pose, float* rows);
  void write_pose(std::size_t pose, float* rows, const PoseOutput& output, bool attributes, bool positions);
  void write_outputs(std::size_t pose, const float* rows, const PoseOutput& output, bool positions);
  void write_detail_vectors(const PoseOutput& output);
  void write(const float* rows, VertexOrder order, const VertexOutput& output, const float* rest = nullptr);
  void write_range(const VertexWriter& writer, VertexRange range) const;
  bool is_plain(const VertexOutput& output, VertexOrder order) const;
  void write_channels(const float* rows, float* channels) const;
  void write_bounds(const float* rows, float* bounds) const;
  bool is_posed(std::size_t block) const {
    const std::uint32_t mesh = layout_.meshes.row_block_meshes[block];
    if (mesh == layout_.meshes.count()) return with_carriers_;
    return (meshes_.empty() || meshes_[mesh]) && !(detail_.level && block >= detail_.level->blocks);
  }

  const EvaluationLayout& layout_;
  const RegionMask regions_;
  const MeshMask meshes_;
  const DetailChoice detail_;
  const bool level_only_;
  bool with_carriers_ = false, all_points_ = false;  // in the current poses
  Workspace& workspace_;
  const std::span<Workspace> workspaces_;
  const Spread spread_;
};

}  // namespace fb::runtime
