#include "model/driven_joints.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>
#include <unordered_set>

#include "base/status.h"

namespace fb {
namespace {

void check_driven_joints(const std::vector<DrivenJoint>& joints) {
  if (joints.size() > most_joints)
    fail(Status::limit, "%zu driven joints; a face has at most %zu", joints.size(), most_joints);
  std::unordered_set<std::string_view> names;
  std::vector<std::uint16_t> depths;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const DrivenJoint& joint = joints[j];
    const char* const name = joint.name.c_str();
    if (joint.name.empty()) fail(Status::bad_data, "driven joint %zu has no name", j);
    if (!names.insert(joint.name).second) fail(Status::bad_data, "two driven joints named \"%s\"", name);
    if (joint.parent != no_joint && joint.parent >= j)
      fail(Status::bad_data, "driven joint \"%s\" has the number %zu and its parent %u; parents come first", name, j,
           joint.parent);
    depths.push_back(joint.parent == no_joint ? 1 : static_cast<std::uint16_t>(depths[joint.parent] + 1));
    if (depths.back() > most_joint_depth)
      fail(Status::limit, "driven joint \"%s\" has more than %zu joints above it", name, most_joint_depth - 1);
    if (joint.numbers >> numbers_a_joint != 0)
      fail(Status::bad_data, "driven joint \"%s\" has numbers that are unknown", name);
    if (joint.outer_rotations.size() > most_outer_rotations)
      fail(Status::limit, "driven joint \"%s\" has %zu outer rotations; it may have %zu", name,
           joint.outer_rotations.size(), most_outer_rotations);
    for (const std::uint8_t rotation : joint.outer_rotations)
      if (rotation == 0 || rotation > joint_rotation)
        fail(Status::bad_data, "driven joint \"%s\" has an outer rotation with the numbers 0x%x", name, rotation);
    if (!std::all_of(joint.rest.begin(), joint.rest.end(), [](float value) { return std::isfinite(value); }))
      fail(Status::not_finite, "driven joint \"%s\" has a frame that is not finite", name);
  }
}

void check_influences_of(const Skin& skin, std::size_t vertex, std::size_t joints) {
  std::uint32_t sum = 0;
  bool ended = false;
  for (std::size_t i = vertex * skin.influences; i < (vertex + 1) * skin.influences; ++i) {
    const float weight = skin.weights[i], whole = weight * static_cast<float>(driven_weight_unit);
    if (!(whole >= 0 && whole <= static_cast<float>(driven_weight_unit)) || whole != std::floor(whole))
      fail(Status::bad_data, "vertex %zu follows a driven joint by the weight %g", vertex, double(weight));
    if (skin.joints[i] >= joints)
      fail(Status::bad_data, "vertex %zu follows driven joint %u of %zu", vertex, unsigned{skin.joints[i]}, joints);
    if (ended && whole > 0) fail(Status::bad_data, "vertex %zu has a driven joint after one of weight 0", vertex);
    ended = whole == 0;
    sum += static_cast<std::uint32_t>(whole);
  }
  if (sum > driven_weight_unit)
    fail(Status::bad_data, "vertex %zu has weights of driven joints that sum to %g, more than 1", vertex,
         double(sum) / driven_weight_unit);
}

}  // namespace

std::vector<std::uint8_t> DrivenJoint::number_kinds() const {
  std::vector<std::uint8_t> kinds;
  for (std::uint8_t n = 0; n < numbers_a_joint; ++n)
    if (numbers >> n & 1) kinds.push_back(n);
  for (const std::uint8_t rotation : outer_rotations)
    for (std::uint8_t n = 0; n < 3; ++n)
      if (rotation >> n & 1) kinds.push_back(n);
  return kinds;
}

std::size_t DrivenJoint::number_count() const {
  auto count = static_cast<std::size_t>(std::popcount(numbers));
  for (const std::uint8_t rotation : outer_rotations) count += static_cast<std::size_t>(std::popcount(rotation));
  return count;
}

std::size_t DrivenJoints::number_count() const {
  std::size_t count = 0;
  for (const DrivenJoint& joint : joints) count += joint.number_count();
  return count;
}

void round_weights(Skin& skin) {
  constexpr float unit = driven_weight_unit, sum_tolerance = 1e-3f;
  const std::size_t width = skin.influences;
  for (std::size_t v = 0; width > 0 && v < skin.weights.size() / width; ++v) {
    const std::span<float> weights = std::span(skin.weights).subspan(v * width, width);
    float sum = 0, rounded = 0;  // of 32 weights: rounded by at most half of the tolerance
    for (float& weight : weights) {
      sum += weight;
      weight = std::round(weight * unit);
      rounded += weight;
    }
    if (weights.empty() || sum == 0) continue;
    if (std::fabs(sum - 1) <= sum_tolerance) *std::max_element(weights.begin(), weights.end()) += unit - rounded;
    for (float& weight : weights) weight /= unit;
  }
  tidy(skin);
}

void check(const DrivenJoints& driven, std::size_t vertices) {
  check_driven_joints(driven.joints);
  if (!driven.scales.empty() && driven.scales.size() != driven.number_count())
    fail(Status::bad_data, "%zu scales for %zu numbers of driven joints", driven.scales.size(), driven.number_count());
  for (const float scale : driven.scales)
    if (!std::isfinite(scale) || !(scale > 0))
      fail(Status::bad_data, "a number of a driven joint has the scale %g, which is not above 0", double(scale));
  const Skin& skin = driven.skin;
  if (skin.influences > most_influences)
    fail(Status::limit, "vertices that follow %u driven joints; they may follow %u", skin.influences, most_influences);
  const std::size_t places = driven.empty() ? 0 : vertices * skin.influences;
  if (skin.joints.size() != places || skin.weights.size() != places || driven.empty() != (skin.influences == 0))
    fail(Status::bad_data, "%zu driven joints with a skin of %zu weights for %zu vertices that follow %u each",
         driven.joints.size(), skin.weights.size(), vertices, skin.influences);
  for (std::size_t v = 0; v < vertices && skin.influences > 0; ++v) check_influences_of(skin, v, driven.joints.size());
}

}  // namespace fb
