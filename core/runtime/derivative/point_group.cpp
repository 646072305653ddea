#include "runtime/derivative/point_group.h"

#include <algorithm>

namespace fb::runtime {
namespace {

std::size_t whole_vectors(std::size_t count) {
  return (count + padding - 1) / padding * padding;
}

// Adds the rows of a vertex, before joints move it, at a level of detail: see slide_vertices.
void add_vertex_rows(const EvaluationLayout& layout, const DetailChoice& choice, std::uint32_t vertex, float weight,
                     std::size_t sum, std::size_t stride, CsrBuilder<RowTerm>& rows) {
  const DetailLayout& details = layout.details;
  const auto surface = static_cast<std::uint32_t>(layout.vertex_count());
  const std::uint32_t of_level = choice.level ? choice.level->vertices : surface;
  const std::uint32_t sliding = choice.next ? choice.next->vertices : of_level;
  const float share = vertex < sliding ? 0.0f : vertex < of_level ? choice.share : 1.0f;
  if (share < 1)
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      rows.add(sum + axis * stride, {3 * vertex + axis, weight * (1.0f - share)});
  if (share == 0) return;
  const DetailPoint& point = details.points[vertex - details.levels.back().vertices];
  for (std::size_t c = 0; c < 3; ++c)  // corners come before their points in baked order
    if (point.weights[c] != 0)
      add_vertex_rows(layout, choice, point.corners[c], weight * share * point.weights[c], sum, stride, rows);
}

bool same_influences(std::span<const JointInfluence> a, std::span<const JointInfluence> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const JointInfluence& x, const JointInfluence& y) {
    return x.offset == y.offset && x.weight == y.weight;
  });
}

}  // namespace

PointGroup::PointGroup(const EvaluationLayout& layout, const DetailChoice& choice,
                       std::span<const WeightedPoint> points, std::span<const std::uint32_t> numbers,
                       std::pmr::memory_resource& memory)
    : numbers_(numbers.begin(), numbers.end(), &memory),
      parts_(&memory),
      part_vertices_(&memory),
      part_joints_(&memory),
      stride_(whole_vectors(numbers.size())),
      rows_([&]() -> BasisRows {
        for (std::uint32_t p = 0; p < numbers.size(); ++p) add_parts(layout, points[numbers[p]], p);
        part_stride_ = whole_vectors(parts_.size());
        return rows_of_parts(layout, choice, memory);
      }()),
      followed_(&memory),
      turns_(&memory),
      of_points_(&memory),
      places_(3 * part_stride_, &memory),
      positions_(3 * stride_, &memory),
      work_(3 * part_stride_, &memory) {
  std::pmr::vector<std::uint32_t> joints(&memory);
  for (const JointInfluence& influence : part_joints_) joints.push_back(influence.offset);
  std::sort(joints.begin(), joints.end());
  joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
  followed_.reserve(joints.size());
  for (const std::uint32_t joint : joints)
    followed_.push_back(
        {joint, std::pmr::vector<float>(4 * part_stride_, &memory), std::pmr::vector<std::uint32_t>(&memory)});
  if (!joints.empty()) turns_.resize(9 * part_stride_);
}

void PointGroup::add_parts(const EvaluationLayout& layout, const WeightedPoint& point, std::uint32_t number) {
  std::array<bool, 3> taken = {};
  for (std::size_t v = 0; v < 3; ++v) {
    if (taken[v] || (point.weights[v] == 0 && v > 0)) continue;
    const auto influences =
        layout.skin.empty() ? std::span<const JointInfluence>() : layout.skin.influences(point.vertices[v]);
    Part part = {number, static_cast<std::uint32_t>(part_vertices_.size()),
                 0,      static_cast<std::uint32_t>(part_joints_.size()),
                 0,      0};
    for (std::size_t w = v; w < 3; ++w) {
      if (point.weights[w] == 0 && w > v) continue;
      if (w > v && !layout.skin.empty() && !same_influences(influences, layout.skin.influences(point.vertices[w])))
        continue;
      taken[w] = true;
      part_vertices_.push_back({point.vertices[w], point.weights[w]});
      part.weight += point.weights[w];
    }
    for (const JointInfluence& influence : influences)
      part_joints_.push_back({influence.offset / joint_matrix_floats, influence.weight});
    part.end_vertex = static_cast<std::uint32_t>(part_vertices_.size());
    part.end_joint = static_cast<std::uint32_t>(part_joints_.size());
    parts_.push_back(part);
  }
}

BasisRows PointGroup::rows_of_parts(const EvaluationLayout& layout, const DetailChoice& choice,
                                    std::pmr::memory_resource& memory) const {
  CsrTable<RowTerm> sums(memory);
  CsrBuilder<RowTerm> builder(3 * part_stride_, 3 * part_vertices_.size(), memory);
  for (std::size_t p = 0; p < parts_.size(); ++p)
    for (std::uint32_t v = parts_[p].first_vertex; v < parts_[p].end_vertex; ++v)
      add_vertex_rows(layout, choice, part_vertices_[v].vertex, part_vertices_[v].weight, p, part_stride_, builder);
  builder.build(sums);
  return BasisRows(layout, choice, sums, memory);
}

void PointGroup::mark_joints(std::span<std::uint8_t> wanted) const {
  for (const FollowedJoint& followed : followed_) wanted[followed.joint] = 1;
}

void PointGroup::find_controls(const CoefficientDerivatives& coefficients, const JointDerivatives& joints) {
  std::pmr::vector<std::uint32_t> of_joints(numbers_.get_allocator());
  for (const FollowedJoint& followed : followed_) {
    const auto of = joints.controls(followed.joint);
    of_joints.insert(of_joints.end(), of.begin(), of.end());
  }
  rows_.find_controls(coefficients, of_joints);
  for (FollowedJoint& followed : followed_)
    for (const std::uint32_t control : joints.controls(followed.joint))
      followed.places.push_back(static_cast<std::uint32_t>(
          std::lower_bound(controls().begin(), controls().end(), control) - controls().begin()));
  if (parts_.size() > numbers_.size()) of_points_.resize(controls().size() * length());
}

void PointGroup::find_positions(const float* rows, const JointDerivatives& joints) {
  std::fill(positions_.begin(), positions_.end(), 0.0f);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const Part& part = parts_[p];
    float at[3] = {};
    for (std::uint32_t v = part.first_vertex; v < part.end_vertex; ++v)
      for (std::size_t axis = 0; axis < 3; ++axis)
        at[axis] += part_vertices_[v].weight * rows[3 * std::size_t(part_vertices_[v].vertex) + axis];
    float moved[3] = {at[0], at[1], at[2]};
    for (std::uint32_t j = part.first_joint; j < part.end_joint; ++j) {
      const JointInfluence& influence = part_joints_[j];
      if (!joints.moves(influence.offset)) continue;
      const Change<float> change = joints.change(influence.offset);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* const row = &change[4 * axis];
        moved[axis] += influence.weight * ((row[0] * at[0] + row[1] * at[1]) + (row[2] * at[2] + row[3] * part.weight));
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      places_[axis * part_stride_ + p] = at[axis];
      positions_[axis * stride_ + part.point] += moved[axis];
    }
  }
}

// The derivatives of parts by a control, as the joints turn them.
void PointGroup::turn(std::size_t control) {
  float* const of = rows_.by_control(control);
  std::copy_n(of, 3 * part_stride_, work_.data());
  const float *const x = work_.data(), *const y = x + part_stride_, *const z = y + part_stride_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float* const to = of + axis * part_stride_;
    const float *const by_x = turns_.data() + 3 * axis * part_stride_, *const by_y = by_x + part_stride_,
                       *const by_z = by_y + part_stride_;
    for (std::size_t p = 0; p < part_stride_; ++p) to[p] += (by_x[p] * x[p] + by_y[p] * y[p]) + by_z[p] * z[p];
  }
}

// x + sum of weight x (change (x, 1)) has as derivative that of x, and sum of weight x (change (that of x, 0)) + weight
// x (that of the change) (x, 1).
void PointGroup::follow_joints(const PoseKernels& kernels, const JointDerivatives& joints) {
  bool turned = false;
  std::fill(turns_.begin(), turns_.end(), 0.0f);
  for (FollowedJoint& followed : followed_) std::fill(followed.rows.begin(), followed.rows.end(), 0.0f);
  for (std::size_t p = 0; p < parts_.size(); ++p)
    for (std::uint32_t j = parts_[p].first_joint; j < parts_[p].end_joint; ++j) {
      const JointInfluence& influence = part_joints_[j];
      const auto followed =
          std::lower_bound(followed_.begin(), followed_.end(), influence.offset,
                           [](const FollowedJoint& f, std::uint32_t joint) { return f.joint < joint; });
      for (std::size_t axis = 0; axis < 3; ++axis)
        followed->rows[axis * part_stride_ + p] += influence.weight * places_[axis * part_stride_ + p];
      followed->rows[3 * part_stride_ + p] += influence.weight * parts_[p].weight;
      if (!joints.moves(influence.offset)) continue;
      turned = true;
      const Change<float> change = joints.change(influence.offset);
      for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
          turns_[(3 * row + column) * part_stride_ + p] += influence.weight * change[4 * row + column];
    }
  for (std::size_t c = 0; c < controls().size() && turned; ++c) turn(c);
  for (const FollowedJoint& followed : followed_)
    for (std::size_t c = 0; c < followed.places.size(); ++c) {
      const Change<float>& rate = joints.derivative(followed.joint, c);
      if (std::all_of(rate.begin(), rate.end(), [](float number) { return number == 0; })) continue;
      float* const to = rows_.by_control(followed.places[c]);
      for (std::size_t axis = 0; axis < 3; ++axis)
        kernels.add_rows(to + axis * part_stride_, &rate[4 * axis], followed.rows.data(), part_stride_, 4,
                         part_stride_);
    }
}

void PointGroup::run(const PoseKernels& kernels, const CoefficientDerivatives& coefficients,
                     const JointDerivatives& joints) {
  rows_.run(kernels, coefficients);
  if (!followed_.empty()) follow_joints(kernels, joints);
  if (of_points_.empty()) return;
  std::fill(of_points_.begin(), of_points_.end(), 0.0f);
  for (std::size_t c = 0; c < controls().size(); ++c)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float* const from = rows_.by_control(c) + axis * part_stride_;
      float* const to = of_points_.data() + c * length() + axis * stride_;
      for (std::size_t p = 0; p < parts_.size(); ++p) to[parts_[p].point] += from[p];
    }
}

}  // namespace fb::runtime
