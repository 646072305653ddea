#include "bake/rig/jointless_source.h"

#include <algorithm>

namespace fb::bake {

JointlessSource::JointlessSource(Source& source) : SourceDecorator(source), rest_(source.rest()) {
  const std::size_t kept = rest_.first_joint_coordinate();
  rest_.carrier_vertices -= static_cast<std::uint32_t>((rest_.points.size() - kept) / 3);
  rest_.points.resize(kept);
  rest_.driven = {};
}

// evaluate(points): of the source, with the numbers of joints, which come last.
template <class Evaluate>
void JointlessSource::evaluate_with_joints(std::size_t count, std::span<float> points, const Evaluate& evaluate) const {
  const std::size_t all = source().rest().points.size(), kept = rest_.points.size();
  std::vector<float> with_joints(count * all);
  evaluate(with_joints);
  for (std::size_t p = 0; p < count; ++p)
    std::copy_n(with_joints.begin() + std::ptrdiff_t(p * all), kept, points.begin() + std::ptrdiff_t(p * kept));
}

void JointlessSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  evaluate_with_joints(count, points, [&](std::span<float> all) { source().read(clip, first, count, all); });
}

void JointlessSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  evaluate_with_joints(count, points, [&](std::span<float> all) { source().evaluate(controls, count, all); });
}

}  // namespace fb::bake
