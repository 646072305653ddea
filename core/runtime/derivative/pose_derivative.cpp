#include "runtime/derivative/pose_derivative.h"

#include <algorithm>
#include <numeric>

#include "runtime/pose_execution.h"

namespace fb::runtime {
namespace {

// The row blocks of a point's vertices, ascending; UINT32_MAX behind them.
using BlocksOfPoint = std::array<std::uint32_t, 3>;

BlocksOfPoint blocks_of(const EvaluationLayout& layout, const WeightedPoint& point) {
  BlocksOfPoint blocks;
  blocks.fill(UINT32_MAX);
  for (std::size_t v = 0; v < 3; ++v) {
    if (point.weights[v] == 0 && v > 0) continue;
    const auto after =
        std::upper_bound(layout.row_blocks.begin(), layout.row_blocks.end(), 3 * point.vertices[v],
                         [](std::uint32_t row, const RowBlockMatrix& block) { return row < block.first_row(); });
    const auto block = static_cast<std::uint32_t>(after - layout.row_blocks.begin()) - 1;
    if (std::find(blocks.begin(), blocks.end(), block) == blocks.end()) blocks[v] = block;
  }
  std::sort(blocks.begin(), blocks.end());
  return blocks;
}

}  // namespace

std::pmr::vector<WeightedPoint> PoseDerivative::all_points(const FrameDerivatives& frames,
                                                           std::span<const WeightedPoint> points,
                                                           std::pmr::memory_resource& memory) {
  std::pmr::vector<WeightedPoint> all(points.begin(), points.end(), &memory);
  frames.visit_vertices([&](std::uint32_t vertex) { all.push_back({{vertex, 0, 0}, {1, 0, 0}}); });
  return all;
}

std::pmr::vector<PointGroup> PoseDerivative::make_groups(const EvaluationLayout& layout, const DetailChoice& choice,
                                                         std::span<const WeightedPoint> points,
                                                         std::pmr::memory_resource& memory) {
  std::pmr::vector<BlocksOfPoint> blocks(&memory);
  for (const WeightedPoint& point : points) blocks.push_back(blocks_of(layout, point));
  std::pmr::vector<std::uint32_t> order(points.size(), &memory);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return blocks[a] != blocks[b] ? blocks[a] < blocks[b] : a < b; });
  std::pmr::vector<PointGroup> groups(&memory);
  for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
    while (end < order.size() && blocks[order[end]] == blocks[order[first]]) ++end;
    groups.emplace_back(layout, choice, points, std::span(order).subspan(first, end - first), memory);
  }
  return groups;
}

JointDerivatives PoseDerivative::make_joints(std::pmr::memory_resource& memory) const {
  std::pmr::vector<std::uint8_t> wanted(layout_.skin.joint_count(), &memory);
  for (const PointGroup& group : groups_) group.mark_joints(wanted);
  frames_.mark_joints(wanted);
  return {layout_, choice_, wanted, memory};
}

template <class Visit>
void PoseDerivative::visit_rows(const Visit& visit) {
  for (PointGroup& group : groups_) visit(group.rows());
  joints_.visit_rows(visit);
}

// A network is followed back once from each of the coefficients that are used, or from each sum that uses some: from
// what is less.
CoefficientDerivatives PoseDerivative::make_coefficients(std::pmr::memory_resource& memory) {
  std::pmr::vector<RegionSums> sums(layout_.networks.size(), &memory);
  for (std::uint32_t r = 0; r < sums.size(); ++r) {
    const std::uint32_t first = layout_.coefficient_offsets[r], last = layout_.coefficient_offsets[r + 1];
    std::size_t count = 0;
    visit_rows([&](BasisRows& rows) { count += rows.count_using(first, last); });
    if (count < last - first) visit_rows([&](BasisRows& rows) { rows.move_region(r, first, last, sums[r]); });
  }
  std::pmr::vector<std::uint8_t> used(coefficient_and_pose_count(layout_), &memory);
  visit_rows([&](BasisRows& rows) { rows.mark_used(used); });
  return {layout_, used, sums, memory};
}

PoseDerivative::PoseDerivative(const Evaluator& evaluator, const Followed& followed, std::pmr::memory_resource& memory)
    : layout_(evaluator.layout()),
      lod_(followed.lod),
      choice_(layout_.details, followed.lod),
      frames_(layout_, followed.sockets, followed.joints, memory),
      groups_(make_groups(layout_, choice_, all_points(frames_, followed.points, memory), memory)),
      places_(&memory),
      joints_(make_joints(memory)),
      coefficients_(make_coefficients(memory)),
      workspace_(evaluator, 1, memory),
      rows_(layout_.row_stride(), &memory) {
  joints_.find_controls(coefficients_);
  std::size_t points = 0;
  for (PointGroup& group : groups_) {
    group.find_controls(coefficients_, joints_);
    points += group.numbers().size();
  }
  places_.resize(points);
  for (std::uint32_t g = 0; g < groups_.size(); ++g)
    for (std::uint32_t p = 0; p < groups_[g].numbers().size(); ++p) places_[groups_[g].numbers()[p]] = {g, p};
  frames_.set_places(std::span(places_).subspan(followed.points.size()));
}

void PoseDerivative::find_positions(const float* controls) {
  PoseOutput output;
  output.positions = {rows_.data(), 3, VertexOrder::baked};
  output.unskinned = true;
  output.all_points = true;
  PoseExecution(layout_, {.lod = lod_}, workspace_).run_pose(controls, output);
  joints_.find_changes(rows_.data());
  for (PointGroup& group : groups_) group.find_positions(rows_.data(), joints_);
  frames_.find_frames(groups_, joints_);
}

void PoseDerivative::run(const float* controls, const std::uint8_t* downwards) {
  find_positions(controls);
  coefficients_.run(controls, downwards);
  joints_.run(layout_.kernels, coefficients_);
  for (PointGroup& group : groups_) group.run(layout_.kernels, coefficients_, joints_);
  if (frames_.count() > 0) frames_.run(groups_, joints_);
}

}  // namespace fb::runtime
