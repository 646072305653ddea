#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <string>
#include <vector>

#include "base/large_pages.h"
#include "model/packed_model.h"
#include "runtime/csr_table.h"
#include "runtime/detail_layout.h"
#include "runtime/driven_skin.h"
#include "runtime/error_prediction.h"
#include "runtime/exact_blend.h"
#include "runtime/feature_graph.h"
#include "runtime/mesh_layout.h"
#include "runtime/metered_memory.h"
#include "runtime/region_network.h"
#include "runtime/row_block_matrix.h"
#include "runtime/socket_frames.h"
#include "runtime/vertex_normals.h"
#include "runtime/vertex_tangents.h"

namespace fb::runtime {

// Where a layout takes its memory from. Both resources must outlive it.
struct EvaluationMemory {
  std::pmr::memory_resource* blocks = nullptr;  // null: the heap, in large pages if the model fills at least one
  std::pmr::memory_resource* heap = std::pmr::get_default_resource();  // also of temporaries
};

// A model laid out for evaluation: built once when it is loaded, immutable afterwards and shared by threads.
// PoseExecution evaluates poses with it.
//
// The matrices take sparse inputs: pairs of an index and a value. Every matrix has an input list in the workspace, and
// so has every gate. Their numbers are, with R regions:
//   0 .. R - 1       the inputs of each region's network
//   R .. 2 R - 1     the features of each region's gate
//   2 R ..           the inputs of each row block's matrix
// The scatter table says for every feature to which lists, at which column and with
// which factor its value goes.
struct EvaluationLayout {
  // Lays out a model that check() accepts. `model` is not needed afterwards. Fails with corrupt if a network
  // overflows at rest.
  EvaluationLayout(const PackedModel& model, const EvaluationMemory& from, const PoseKernels& kernels);
  EvaluationLayout(const EvaluationLayout&) = delete;
  EvaluationLayout& operator=(const EvaluationLayout&) = delete;

  // Row blocks whose inputs are quantised before any of them is multiplied: enough for the prefetches of their columns
  // to complete, few enough for these columns to stay in the caches.
  static constexpr std::size_t row_blocks_per_pass = 16;

  struct ScatterEntry {
    std::uint32_t list, offset;  // see MatrixInputs::offsets
    float scale;
  };

  std::size_t vertex_count() const { return meshes.surface_vertices; }
  // Row blocks of the surface; those behind them have numbers.
  std::size_t surface_blocks() const {
    const auto& of_block = meshes.row_block_meshes;
    return static_cast<std::size_t>(std::find(of_block.begin(), of_block.end(), meshes.count()) - of_block.begin());
  }
  // Floats between the rows of poses in a workspace: one more than rows, because vertices are read as vectors of four.
  std::size_t row_stride() const { return rest_positions.size() + 1; }
  // Of any level of detail.
  std::size_t max_polygons() const { return std::max(normals.graph().polygons(), max_level_polygons()); }
  std::size_t max_level_polygons() const {
    std::size_t polygons = 0;
    for (const DetailLevelLayout& level : details.levels)
      polygons = std::max(polygons, level.normals.graph().polygons());
    return polygons;
  }
  std::size_t gate_list(std::size_t region) const { return networks.size() + region; }
  std::size_t row_block_list(std::size_t block) const { return 2 * networks.size() + block; }
  // Entries, with padding, of the lists of row blocks first..last - 1.
  std::size_t row_block_entries(std::size_t first, std::size_t last) const {
    return list_offsets[row_block_list(last)] - list_offsets[row_block_list(first)];
  }

  RigSchema schema;
  const PoseKernels& kernels;
  LargePages pages;
  MeteredMemory memory;
  FeatureGraph features;
  std::vector<std::string> region_names;
  std::pmr::vector<RegionNetwork> networks;  // by region
  std::pmr::vector<float> gate_slopes;       // by region; 0: no gate
  std::pmr::vector<RowBlockMatrix> row_blocks;
  std::pmr::vector<std::uint32_t> direct;               // graph indices of the features that are coefficients
  std::pmr::vector<std::uint32_t> coefficient_offsets;  // of each region's coefficients; one more than regions
  std::pmr::vector<std::uint32_t> list_offsets;         // of the input lists in a workspace; one more than lists
  CsrTable<ScatterEntry> scatter;                       // by feature
  CsrTable<RegionInputs> row_block_regions;             // by row block
  std::pmr::vector<float> rest_positions,
      rest_rows;  // in source order; in the order of rows, padded; what carries numbers is last
  std::pmr::vector<std::uint32_t> order, baked_index;  // see Basis::order, and its inverse; empty: source order
  MeshLayout meshes;
  DetailLayout details;
  DrivenSkin skin;
  SocketFrames sockets;
  ErrorPrediction errors;
  ExactBlend exact;
  VertexNormals normals;
  VertexTangents tangents;
  std::size_t coefficient_count;
  std::size_t max_width = 0, max_work_size = 0;  // of networks, see RegionNetwork
  std::size_t max_pass_entries = 0;              // row_block_entries() of a pass
  std::size_t max_block_rows = 0;
  bool blocks_of_vertices = true;  // whether no row block begins within a vertex

 private:
  void add_networks(const PackedModel& model, std::pmr::memory_resource& heap);
  void add_row_blocks(const PackedModel& model);
  void find_list_offsets(const PackedModel& model);
  void find_scatter_table(const PackedModel& model, std::pmr::memory_resource& heap);
  void find_row_block_regions(std::pmr::memory_resource& heap);
};

}  // namespace fb::runtime
