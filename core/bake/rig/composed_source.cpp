#include "bake/rig/composed_source.h"

#include <algorithm>
#include <cmath>

#include "bake/rig/driven_pose.h"
#include "base/hash.h"

namespace fb::bake {
namespace {

constexpr double rounding = 1e-6;  // radians, or of the joint's distance from the origin

Axis at_value(const VectorCurve& curve, float value) {
  const auto upper = std::ranges::upper_bound(curve.values, value) - curve.values.begin();
  const auto b = std::size_t(std::clamp<std::ptrdiff_t>(upper, 1, std::ssize(curve.values) - 1)), a = b - 1;
  const double part = (double(value) - curve.values[a]) / (double(curve.values[b]) - curve.values[a]);
  Axis vector;
  for (std::size_t k = 0; k < 3; ++k) vector[k] = (1 - part) * curve.vectors[a][k] + part * curve.vectors[b][k];
  return vector;
}

Axis sum_of(const VectorSum& curves, std::span<const float> controls) {
  Axis sum = {};
  for (const VectorCurve& curve : curves) {
    const Axis vector = at_value(curve, controls[curve.control]);
    for (std::size_t k = 0; k < 3; ++k) sum[k] += vector[k];
  }
  return sum;
}

// Which components are ever more than nothing.
std::uint32_t components_of(const VectorSum& curves, double nothing) {
  std::uint32_t components = 0;
  for (const VectorCurve& curve : curves)
    for (const Axis& vector : curve.vectors)
      for (std::size_t k = 0; k < 3; ++k)
        if (std::fabs(vector[k]) > nothing) components |= 1u << k;
  return components;
}

double rounding_of(const DrivenJoint& joint) {
  return rounding * std::max({std::fabs(joint.rest[3]), std::fabs(joint.rest[7]), std::fabs(joint.rest[11])});
}

}  // namespace

ComposedSource::ComposedSource(Source& source, std::vector<JointComposition> compositions)
    : ConvertedSource(source), compositions_(std::move(compositions)) {
  remove_joint_vertices(rest_);
  std::size_t from = source.rest().first_joint_coordinate(), to = rest_.points.size();
  for (std::size_t j = 0; j < compositions_.size(); ++j) {
    DrivenJoint& joint = rest_.driven.joints[j];
    from_.push_back(from), to_.push_back(to);
    from += joint.number_count();
    for (const VectorSum& rotation : compositions_[j].outer_rotations)
      joint.outer_rotations.push_back(static_cast<std::uint8_t>(components_of(rotation, rounding)));
    joint.numbers |= components_of(compositions_[j].pivot, rounding_of(joint)) * (joint_pivot & -joint_pivot);
    to += joint.number_count();
  }
  add_joint_vertices(rest_);
}

// One with other compositions has other points.
std::string ComposedSource::version() const {
  std::uint64_t hash = 0;
  const auto add = [&](const VectorSum& sum) {
    for (const VectorCurve& curve : sum) {
      hash = hash64_of<float>(curve.values, hash64_of<std::uint32_t>(std::span(&curve.control, 1), hash));
      for (const Axis& vector : curve.vectors) hash = hash64_of<double>(vector, hash);
    }
  };
  for (const JointComposition& composition : compositions_) {
    for (const VectorSum& rotation : composition.outer_rotations) add(rotation);
    add(composition.pivot);
  }
  return source().version() + format(" (composition %016llx)", static_cast<unsigned long long>(hash));
}

void ComposedSource::compose_joint(std::size_t j, std::span<const float> controls, const float* from, float* to) const {
  const DrivenJoint &before = source().rest().driven.joints[j], &joint = rest_.driven.joints[j];
  const JointComposition& composition = compositions_[j];
  if (composition.empty()) {
    std::copy_n(from, joint.number_count(), to);
    return;
  }
  const float* scale = &source().rest().driven.scales[from_[j] - from_[0]];
  double n[numbers_a_joint] = {};
  for (const std::uint8_t kind : before.number_kinds()) n[kind] = double(*scale++) * *from++;
  const Axis whole = {n[0], n[1], n[2]}, pivot = sum_of(composition.pivot, controls);
  const Frame<double> rotation = rotation_about(whole);
  for (std::size_t a = 0; a < 3; ++a) {
    const double* const row = &rotation[4 * a];
    n[3 + a] -= pivot[a] - (row[0] * pivot[0] + row[1] * pivot[1] + row[2] * pivot[2]);
    n[9 + a] = pivot[a];
  }
  std::vector<Axis> outer;
  for (const VectorSum& sum : composition.outer_rotations) outer.push_back(sum_of(sum, controls));
  Axis first = whole;
  for (std::size_t o = outer.size(); o-- > 0;)
    if (outer[o] != Axis{}) first = turned_before(first, outer[o]);
  std::ranges::copy(first, n);

  scale = &rest_.driven.scales[to_[j] - to_[0]];
  const double nothing[2] = {rounding, rounding_of(joint)};
  const auto put = [&](double number, std::size_t kind) {
    const bool length = (joint_translation | joint_pivot) >> kind & 1;
    *to++ = std::fabs(number) <= nothing[length] ? 0 : static_cast<float>(number / *scale);
    ++scale;
  };
  for (std::size_t kind = 0; kind < numbers_a_joint; ++kind)
    if (joint.numbers >> kind & 1) put(n[kind], kind);
  for (std::size_t o = 0; o < outer.size(); ++o)
    for (std::size_t kind = 0; kind < 3; ++kind)
      if (joint.outer_rotations[o] >> kind & 1) put(outer[o][kind], kind);
}

void ComposedSource::convert(std::span<const float> controls, std::span<const float> from, std::size_t poses,
                             std::span<float> to) const {
  const std::size_t width = schema().control_count(), all = source().rest().points.size(), here = rest_.points.size();
  for (std::size_t p = 0; p < poses; ++p) {
    const float* const pose = from.data() + p * all;
    float* const composed = to.data() + p * here;
    std::copy_n(pose, from_[0], composed);
    std::fill(composed + to_[0], composed + here, 0.0f);
    for (std::size_t j = 0; j < compositions_.size(); ++j)
      compose_joint(j, controls.subspan(p * width, width), pose + from_[j], composed + to_[j]);
  }
}

}  // namespace fb::bake
