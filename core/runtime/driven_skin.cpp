#include "runtime/driven_skin.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "runtime/joint_change.h"

namespace fb::runtime {
namespace {

// A matrix for kernels has columns.
float& entry(float* matrix, std::size_t row, std::size_t column) {
  return matrix[4 * column + row];
}
Change<float> change_of(const float* matrix) {
  Change<float> change;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column) change[4 * row + column] = matrix[4 * column + row];
  return change;
}

}  // namespace

DrivenSkin::DrivenSkin(const PackedModel& model, std::span<const std::uint32_t> baked_index,
                       std::pmr::memory_resource& memory, std::pmr::memory_resource& heap)
    : joints_(&memory),
      scales_(&memory),
      outer_(&memory),
      influences_(memory),
      blocks_(&memory),
      block_joints_(memory),
      groups_(memory),
      others_(memory),
      weights_(&memory) {
  const DrivenJoints& driven = model.rest.driven;
  if (driven.empty()) return;
  first_row_ = model.rest.first_joint_coordinate();
  auto row = static_cast<std::uint32_t>(first_row_);
  scales_.assign(driven.scales.begin(), driven.scales.end());
  joints_.reserve(driven.joints.size());
  for (const DrivenJoint& from : driven.joints) {
    const auto first = row, outer = static_cast<std::uint32_t>(outer_.size());
    row += static_cast<std::uint32_t>(from.number_count());
    outer_.insert(outer_.end(), from.outer_rotations.begin(), from.outer_rotations.end());
    joints_.push_back(
        {from.parent, first, row, from.numbers, outer, static_cast<std::uint32_t>(outer_.size()), from.rest});
  }
  const Skin& skin = driven.skin;
  const auto vertices = static_cast<std::uint32_t>(model.rest.surface_vertex_count());
  CsrBuilder<JointInfluence> influences(vertices, 0, heap);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const std::size_t first = std::size_t(v) * skin.influences;
    for (std::size_t i = first; i < first + skin.count(v); ++i)
      influences.add(baked_index.empty() ? v : baked_index[v],
                     {joint_matrix_floats * std::uint32_t{skin.joints[i]}, skin.weights[i]});
  }
  influences.build(influences_);
  find_blocks(model, heap);
  find_groups(heap);
}

void DrivenSkin::find_blocks(const PackedModel& model, std::pmr::memory_resource& heap) {
  const auto vertices = static_cast<std::uint32_t>(model.rest.surface_vertex_count());
  const auto range_of = [&](const PackedRowBlock& block) {
    return vertices_of_rows(block.first_row, block.row_count, vertices);
  };
  const auto follows = [&](const PackedRowBlock& block) {
    const VertexRange range = range_of(block);
    return range.begin < range.end && influences_.row_offsets[range.begin] < influences_.row_offsets[range.end];
  };
  const auto count = static_cast<std::size_t>(std::count_if(model.row_blocks.begin(), model.row_blocks.end(), follows));
  blocks_.reserve(count);
  CsrBuilder<std::uint32_t> joints(count, 0, heap);
  std::pmr::vector<std::uint32_t> last_block(joints_.size(), UINT32_MAX, &heap);
  for (std::uint32_t number = 0; number < model.row_blocks.size(); ++number) {
    if (!follows(model.row_blocks[number])) continue;
    const auto b = static_cast<std::uint32_t>(blocks_.size());
    blocks_.push_back({number, range_of(model.row_blocks[number])});
    for (std::uint32_t v = blocks_[b].vertices.begin; v < blocks_[b].vertices.end; ++v)
      for (const JointInfluence& influence : influences_.row(v)) {
        const std::uint32_t joint = influence.offset / joint_matrix_floats;
        if (last_block[joint] != b) joints.add(b, joint);
        last_block[joint] = b;
      }
  }
  joints.build(block_joints_);
}

// Makes a group of the vertices from `vertex` on and appends its weights. Returns false, appending none, if they follow
// too many joints, in different orders, or one twice.
bool DrivenSkin::find_group(std::uint32_t vertex, SkinGroup& group, std::pmr::vector<float>& weights) const {
  group = {3 * vertex, 0, {}, static_cast<std::uint32_t>(weights.size())};
  const auto end_of = [&] { return group.offset + group.joints; };
  for (std::uint32_t v = vertex; v < vertex + SkinGroup::vertices; ++v)
    for (const JointInfluence& influence : influences_.row(v)) {
      if (std::find(group.offset, end_of(), influence.offset) != end_of()) continue;
      if (group.joints == SkinGroup::most_joints) return false;
      group.offset[group.joints++] = influence.offset;
    }
  float of_joints[SkinGroup::most_joints][SkinGroup::vertices] = {};
  for (std::uint32_t v = vertex; v < vertex + SkinGroup::vertices; ++v) {
    const std::uint32_t* next = group.offset;
    for (const JointInfluence& influence : influences_.row(v)) {
      const std::uint32_t* const at = std::find(group.offset, end_of(), influence.offset);
      if (at < next) return false;
      next = at + 1;
      of_joints[at - group.offset][v - vertex] = influence.weight;
    }
  }
  for (std::uint32_t j = 0; j < group.joints; ++j)
    weights.insert(weights.end(), of_joints[j], of_joints[j] + SkinGroup::vertices);
  return true;
}

void DrivenSkin::find_groups(std::pmr::memory_resource& heap) {
  CsrBuilder<SkinGroup> groups(blocks_.size(), 0, heap);
  CsrBuilder<VertexRange> others(blocks_.size(), 0, heap);
  std::pmr::vector<float> weights(&heap);
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    for (std::uint32_t v = blocks_[b].vertices.begin, end = v; v < blocks_[b].vertices.end; v = end) {
      end = std::min(v + SkinGroup::vertices, blocks_[b].vertices.end);
      SkinGroup group;
      if (influences_.row_offsets[v] == influences_.row_offsets[end]) continue;
      if (end - v == SkinGroup::vertices && find_group(v, group, weights))
        groups.add(b, group);
      else
        others.add(b, {v, end});
    }
  groups.build(groups_);
  others.build(others_);
  weights_.assign(weights.begin(), weights.end());
}

// `rows`: those of its numbers. parent: the matrix of a parent that moved, or null.
void DrivenSkin::find_matrix(const Joint& joint, const float* rows, const float* parent, float* matrix) const {
  const float* scale = &scales_[joint.first_row - first_row_];
  const auto next = [&] { return *scale++ * *rows++; };
  const Change<float> change = change_of_joint<float>(joint.rest, joint.numbers, outer_rotations(joint), next);
  if (!parent) {
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 4; ++column) entry(matrix, row, column) = change[4 * row + column];
    return;
  }
  const Change<float> above = change_of(parent);
  const Change<float> both = below_parent(above, change);
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column) entry(matrix, row, column) = both[4 * row + column];
}

void DrivenSkin::find_matrices(const float* rows, State& state) const {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const float* const own = rows + joint.first_row;
    const float* const end = rows + joint.end_row;
    float* const matrix = state.matrices[j].numbers;
    const bool below = joint.parent != no_joint && state.moved[joint.parent];
    const float* const parent = below ? state.matrices[joint.parent].numbers : nullptr;
    const bool still = std::all_of(own, end, [](float coordinate) { return coordinate == 0; });
    if (!still)
      find_matrix(joint, own, parent, matrix);
    else if (below)
      std::copy_n(parent, joint_matrix_floats, matrix);
    else if (state.moved[j])
      std::fill_n(matrix, joint_matrix_floats, 0.0f);
    state.moved[j] = !still || below;
  }
  state.finite = std::all_of(state.matrices.begin(), state.matrices.end(), [](const JointMatrix& matrix) {
    return std::all_of(std::begin(matrix.numbers), std::end(matrix.numbers),
                       [](float number) { return std::isfinite(number); });
  });
}

bool DrivenSkin::run(const PoseKernels& kernels, std::size_t block, std::uint32_t end, const State& state,
                     float* rows) const {
  const VertexRange range = blocks_[block].vertices;
  const auto joints = block_joints_.row(block);
  const auto moved = [&](std::uint32_t joint) { return state.moved[joint] != 0; };
  if (range.begin >= end || std::none_of(joints.begin(), joints.end(), moved)) return false;
  const SkinTable table = {influences_.row_offsets.data(), influences_.entries.data()};
  const float* const matrices = state.matrices.data()->numbers;
  if (!state.finite) {  // a weight of 0 would not leave them out
    kernels.skin_vertices(table, range.begin, range.end, matrices, rows);
    return true;
  }
  const std::span<const SkinGroup> groups = groups_.row(block);
  kernels.skin_groups(groups.data(), groups.size(), weights_.data(), matrices, rows);
  for (const VertexRange& other : others_.row(block))
    kernels.skin_vertices(table, other.begin, other.end, matrices, rows);
  return true;
}

void DrivenSkin::write_frames(const State& state, float* frames) const {
  for (std::size_t j = 0; j < joints_.size(); ++j, frames += frame_floats) {
    const std::array<float, 12>& rest = joints_[j].rest;
    std::copy_n(rest.data(), frame_floats, frames);
    if (!state.moved[j]) continue;
    const Change<float> change = change_of(state.matrices[j].numbers);
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column)
        frames[4 * row + column] = rest[4 * row + column] + times(&change[4 * row], rest, column);
      frames[4 * row + 3] = rest[4 * row + 3] + (times(&change[4 * row], rest, 3) + change[4 * row + 3]);
    }
  }
}

}  // namespace fb::runtime
