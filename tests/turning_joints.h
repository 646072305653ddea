// Driven joints with several rotations and pivots, for models of test_models.h.
#pragma once

#include "test_models.h"

namespace fb {

// Gives a model that has driven joints (drive_joints()) three more, and vertices that follow them: an eye on the
// tongue, which turns three times and about a pivot, a brow that turns fifteen times, never by numbers of its own, and
// an ear on it, which does everything.
inline void add_turning_joints(PackedModel& model, std::uint64_t seed = 1) {
  Random random(seed, 5);
  DrivenJoints& driven = model.rest.driven;
  const auto first = static_cast<std::uint16_t>(driven.joints.size());
  const std::size_t numbers = driven.number_count();
  std::vector<std::uint8_t> turns;
  for (std::uint8_t turn = 0; turn < most_outer_rotations; ++turn) turns.push_back(1 + turn % 7);
  const std::uint32_t all = joint_translation | joint_scale | 0xa01;
  driven.joints.push_back(
      {"eye", 1, joint_rotation | joint_pivot, {0.6f, -0.8f, 0, 1, 0.8f, 0.6f, 0, 2, 0, 0, 1, -1}, {5, 7}});
  driven.joints.push_back({"brow", no_joint, 0, {0, 0, 1, 2, 1, 0, 0, 3, 0, 1, 0, 0.5f}, turns});
  driven.joints.push_back({"ear", first + 1u, all, {1, 0, 0, 3, 0, 0.8f, 0.6f, 2, 0, -0.6f, 0.8f, 1}, {2}});
  const std::size_t now = driven.number_count();
  for (std::size_t n = numbers; n < now; ++n) driven.scales.push_back(random.uniform(0.25f, 0.75f));
  for (std::size_t v = 0; v < model.rest.surface_vertex_count(); v += 2)
    driven.skin.joints[v * driven.skin.influences] = static_cast<std::uint16_t>(first + v / 2 % 3);
  const auto row = static_cast<std::uint32_t>(model.rest.points.size()),
             carriers = static_cast<std::uint32_t>((now + 2) / 3 - (numbers + 2) / 3);
  for (std::uint32_t c = 0; c < carriers && !model.order.empty(); ++c) model.order.push_back(row / 3 + c);
  model.rest.points.resize(row + 3 * carriers);
  model.rest.carrier_vertices += carriers;
  model.row_blocks.push_back(random_row_block(random, row, 3 * carriers, {0, 1, 2, 3, 4}, 0.5f));
  for (ExactPose& pose : model.exact)
    for (std::uint32_t r = 0; r < 3 * carriers; ++r)
      pose.values.push_back(static_cast<std::int32_t>(random.uniform(-1, 1) * 1e5f));
}

}  // namespace fb
