#include "bake/levels/level_plan.h"

#include <cmath>

#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {

std::vector<DetailLevel> LevelPlan::levels_of(const PackedModel& model) const {
  std::vector<DetailLevel> made = levels;
  const auto surface = static_cast<std::uint32_t>(model.rest.surface_vertex_count());
  for (std::uint32_t i = 0; i < surface; ++i) {
    const std::uint32_t v = model.order.empty() ? i : model.order[i];
    for (std::size_t k = 0; k < coarsest[v]; ++k) {
      if (made[k].vertices != i) fail(Status::internal, "vertices are not ordered by level");
      ++made[k].vertices;
    }
    if (coarsest[v] < made.size()) made[coarsest[v]].points.push_back(points[v]);
  }
  for (DetailLevel& level : made) level.used_coefficients.assign(model.columns - model.direct.size(), 1);
  return made;
}

std::vector<float> mixed_points(std::span<const float> rest, std::span<const float> displacements, std::uint64_t seed) {
  std::vector<double> mixed(rest.begin(), rest.end());
  const std::size_t poses = rest.empty() ? 0 : displacements.size() / rest.size();
  for (std::size_t pose = 0; pose < poses; ++pose) {
    // A rotation by a random unit quaternion.
    Random random = open_stream(seed, Stream::level_turns, pose);
    double q[4], squares = 0;
    for (double& x : q) x = random.normal(), squares += x * x;
    const double s = squares > 0 ? 2 / squares : 0, share = 1 / std::sqrt(double(poses));
    const auto [w, x, y, z] = q;
    const double turn[3][3] = {{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
                               {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
                               {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}};
    const float* const moved = displacements.data() + pose * rest.size();
    for (std::size_t v = 0; v + 3 <= rest.size(); v += 3)
      for (std::size_t row = 0; row < 3; ++row)
        mixed[v + row] += share * (turn[row][0] * moved[v] + turn[row][1] * moved[v + 1] + turn[row][2] * moved[v + 2]);
  }
  return {mixed.begin(), mixed.end()};
}

}  // namespace fb::bake
