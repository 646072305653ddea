#include "bake/analysis/prune_correctives.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/analysis/feature_usage.h"

namespace fb::bake {
namespace {

double squares(const float* offset) {
  return double(offset[0]) * offset[0] + double(offset[1]) * offset[1] + double(offset[2]) * offset[2];
}

}  // namespace

std::size_t prune_correctives(RigAnalysis& analysis, const RigSchema& schema, std::span<const float> controls,
                              double diagonal, double bytes) {
  SparseBlendshapes& base = analysis.base;
  const std::vector<FeatureUsage> uses = feature_usage(base.features, schema, controls);
  std::vector<std::size_t> shape_of(base.features.size(), base.shapes.size());
  for (std::size_t s = 0; s < base.shapes.size(); ++s) shape_of[base.shapes[s].feature] = s;

  // What each corrective is worth and costs.
  std::vector<double> worth(analysis.correctives.size()), cost(worth.size());
  for (std::size_t i = 0; i < worth.size(); ++i)
    for (const std::uint32_t feature : analysis.correctives[i].features) {
      if (shape_of[feature] == base.shapes.size()) continue;
      const SparseShape& shape = base.shapes[shape_of[feature]];
      double size = 0;
      for (std::size_t v = 0; v < shape.vertices.size(); ++v) size += squares(&shape.offsets[3 * v]);
      worth[i] += uses[feature].square * size;
      cost[i] += uses[feature].active * 3 * static_cast<double>(shape.vertices.size());
    }
  std::vector<std::size_t> order(worth.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return worth[a] * cost[b] > worth[b] * cost[a]; });

  std::vector<char> dropped(base.shapes.size());
  std::size_t count = 0;
  double spent = 0;
  const std::size_t vertices = analysis.residual_motion.size() / std::max<std::size_t>(schema.control_count(), 1);
  for (const std::size_t i : order) {
    if (spent + cost[i] <= bytes) {
      spent += cost[i];
      continue;
    }
    ++count;
    for (const std::uint32_t feature : analysis.correctives[i].features) {
      if (shape_of[feature] == base.shapes.size() || dropped[shape_of[feature]]) continue;
      dropped[shape_of[feature]] = 1;
      const SparseShape& shape = base.shapes[shape_of[feature]];
      for (const std::uint32_t control : analysis.correctives[i].controls)
        for (std::size_t v = 0; v < shape.vertices.size(); ++v) {
          float& motion = analysis.residual_motion[control * vertices + shape.vertices[v]];
          motion = static_cast<float>(std::sqrt(
              double(motion) * motion + uses[feature].square * squares(&shape.offsets[3 * v]) / (diagonal * diagonal)));
        }
    }
  }
  std::vector<SparseShape> kept;
  for (std::size_t s = 0; s < base.shapes.size(); ++s)
    if (!dropped[s]) kept.push_back(std::move(base.shapes[s]));
  base.shapes = std::move(kept);
  return count;
}

}  // namespace fb::bake
