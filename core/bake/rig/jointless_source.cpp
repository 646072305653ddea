#include "bake/rig/jointless_source.h"

#include <algorithm>

#include "bake/rig/driven_pose.h"

namespace fb::bake {

JointlessSource::JointlessSource(Source& source) : ConvertedSource(source) {
  remove_joint_vertices(rest_);
  rest_.driven = {};
}

void JointlessSource::convert(std::span<const float>, std::span<const float> from, std::size_t poses,
                              std::span<float> to) const {
  const std::size_t all = source().rest().points.size(), kept = rest_.points.size();
  for (std::size_t p = 0; p < poses; ++p)
    std::ranges::copy(from.subspan(p * all, kept), to.begin() + std::ptrdiff_t(p * kept));
}

}  // namespace fb::bake
