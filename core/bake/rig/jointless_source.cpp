#include "bake/rig/jointless_source.h"

#include <algorithm>

#include "bake/rig/converted_backend.h"

namespace fb::bake {

JointlessSource::JointlessSource(Source& source) : SourceDecorator(source), rest_(source.rest()) {
  const std::size_t kept = rest_.first_joint_coordinate();
  rest_.carrier_vertices -= static_cast<std::uint32_t>((rest_.points.size() - kept) / 3);
  rest_.points.resize(kept);
  rest_.driven = {};
}

void JointlessSource::drop_numbers(std::span<const float> from, std::size_t poses, std::span<float> to) const {
  const std::size_t all = source().rest().points.size(), kept = rest_.points.size();
  for (std::size_t p = 0; p < poses; ++p)
    std::ranges::copy(from.subspan(p * all, kept), to.begin() + std::ptrdiff_t(p * kept));
}

void JointlessSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  std::vector<float> with_joints(count * source().rest().points.size());
  source().read(clip, first, count, with_joints);
  drop_numbers(with_joints, count, points);
}

void JointlessSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  std::vector<float> with_joints(count * source().rest().points.size());
  source().evaluate(controls, count, with_joints);
  drop_numbers(with_joints, count, points);
}

std::unique_ptr<EvaluationBackend> JointlessSource::make_backend(const Parallel& parallel) {
  const auto convert = [this](std::span<const float>, std::span<const float> from, std::size_t poses,
                              std::span<float> to) { drop_numbers(from, poses, to); };
  return std::make_unique<ConvertedBackend>(source().make_backend(parallel), source().rest().points.size(), convert);
}

}  // namespace fb::bake
