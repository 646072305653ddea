// Joints that the controls drive, and the vertices that follow them. core/archive/EVALUATION.md defines every
// operation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"
#include "runtime/csr_table.h"
#include "runtime/kernels/pose_kernels.h"
#include "runtime/mesh_layout.h"

namespace fb::runtime {

class DrivenSkin {
 public:
  static constexpr std::size_t frame_floats = 12;

  // How the joints of a pose moved.
  struct State {
    State(const DrivenSkin& skin, std::pmr::memory_resource& memory)
        : matrices(skin.joint_count(), &memory), moved(skin.joint_count(), &memory) {}

    std::pmr::vector<JointMatrix> matrices;  // by joint; 0 for those that did not move
    std::pmr::vector<std::uint8_t> moved;
    bool finite = true;  // all numbers of matrices
  };

  // baked_index: see VertexWriter.
  DrivenSkin(const PackedModel& model, std::span<const std::uint32_t> baked_index, std::pmr::memory_resource& memory,
             std::pmr::memory_resource& heap);

  // A row block with vertices that follow joints.
  struct Block {
    std::uint32_t number;
    VertexRange vertices;
  };

  bool empty() const { return joints_.empty(); }
  std::span<const Block> blocks() const { return blocks_; }
  std::size_t joint_count() const { return joints_.size(); }
  // Finds how joints moved. `rows`: of a pose, which the numbers of joints are the last of.
  void find_matrices(const float* rows, State& state) const;
  // Moves the vertices of blocks()[block] below `end`, and maybe others of the block. Returns whether any joint moved
  // that they follow.
  bool run(const PoseKernels& kernels, std::size_t block, std::uint32_t end, const State& state, float* rows) const;
  // frame_floats a joint.
  void write_frames(const State& state, float* frames) const;

  struct Joint {
    std::uint32_t outer_count() const { return end_outer - first_outer; }
    std::uint32_t parent, first_row, end_row;  // rows of its numbers
    std::uint32_t numbers;
    std::uint32_t first_outer, end_outer;  // of its outer rotations among those of all joints
    Frame<float> rest;
  };
  const Joint& joint(std::size_t index) const { return joints_[index]; }
  // Which numbers each of its outer rotations has.
  std::span<const std::uint8_t> outer_rotations(const Joint& joint) const {
    return std::span(outer_).subspan(joint.first_outer, joint.outer_count());
  }
  // A number is this times its row.
  float scale(std::uint32_t row) const { return scales_[row - first_row_]; }
  // The joints that a vertex follows, in baked order; `offset` is joint_matrix_floats times their index.
  std::span<const JointInfluence> influences(std::uint32_t vertex) const { return influences_.row(vertex); }

 private:
  void find_matrix(const Joint& joint, const float* rows, const float* parent, float* matrix) const;
  void find_blocks(const PackedModel& model, std::pmr::memory_resource& heap);
  void find_groups(std::pmr::memory_resource& heap);
  bool find_group(std::uint32_t vertex, SkinGroup& group, std::pmr::vector<float>& weights) const;

  std::pmr::vector<Joint> joints_;
  std::pmr::vector<float> scales_;        // of all numbers
  std::pmr::vector<std::uint8_t> outer_;  // of all joints: which numbers an outer rotation has
  std::size_t first_row_ = 0;             // of all numbers
  CsrTable<JointInfluence> influences_;   // by vertex, in baked order
  std::pmr::vector<Block> blocks_;
  CsrTable<std::uint32_t> block_joints_;  // by block: the joints that its vertices follow
  CsrTable<SkinGroup> groups_;            // by block: of its vertices
  CsrTable<VertexRange> others_;          // by block: its vertices in no group that follow a joint
  std::pmr::vector<float> weights_;       // of groups
};

}  // namespace fb::runtime
