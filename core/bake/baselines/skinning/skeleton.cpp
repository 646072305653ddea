#include "bake/baselines/skinning/skeleton.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "bake/regions/surface_graph.h"
#include "base/checked.h"

namespace fb::bake {

double weight_roughness(const Skeleton& skeleton, const Mesh& rest) {
  std::vector<double> difference(skeleton.bone_count());
  double sum = 0;
  const SurfaceGraph graph(rest, {});
  for (std::uint32_t a = 0; a < graph.size(); ++a)
    for (const auto& [b, length] : graph.edges(a)) {
      for (std::size_t i = 0; i < bones_per_vertex; ++i) {
        difference[skeleton.bones[a][i]] += skeleton.weights[a][i];
        difference[skeleton.bones[b][i]] -= skeleton.weights[b][i];
      }
      for (const std::uint32_t v : {a, b})
        for (const std::uint32_t bone : skeleton.bones[v]) {
          sum += difference[bone] * difference[bone];
          difference[bone] = 0;
        }
    }
  return sum / 2;  // every edge is visited from both ends
}

std::vector<float> skinning_shapes(const Skeleton& skeleton, const Mesh& rest) {
  const std::size_t rows = rest.points.size();
  std::vector<float> shapes(skeleton.parameter_count() * rows);
  for (std::size_t v = 0; v < rest.vertex_count(); ++v)
    for (std::size_t i = 0; i < bones_per_vertex; ++i) {
      const std::size_t bone = skeleton.bones[v][i];
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t k = 0; k < 4; ++k) {
          const float factor = k < 3 ? rest.points[3 * v + k] - skeleton.centres[bone][k] : 1.0f;
          shapes[(12 * bone + 4 * axis + k) * rows + 3 * v + axis] += skeleton.weights[v][i] * factor;
        }
    }
  return shapes;
}

void add_skinned(const Skeleton& skeleton, const Mesh& rest, std::span<const float> transforms, float sign,
                 std::span<float> displacements) {
  for (std::size_t v = 0; v < rest.vertex_count(); ++v)
    for (std::size_t i = 0; i < bones_per_vertex; ++i) {
      const float weight = sign * skeleton.weights[v][i];
      if (weight == 0) continue;
      const std::size_t bone = skeleton.bones[v][i];
      const float* point = rest.points.data() + 3 * v;
      const auto& centre = skeleton.centres[bone];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* row = transforms.data() + 12 * bone + 4 * axis;
        displacements[3 * v + axis] += weight * (row[0] * (point[0] - centre[0]) + row[1] * (point[1] - centre[1]) +
                                                 row[2] * (point[2] - centre[2]) + row[3]);
      }
    }
}

Region transform_region(const Skeleton& skeleton, std::vector<std::uint32_t> features,
                        const std::vector<float>& transforms) {
  const std::size_t parameters = skeleton.parameter_count();
  DenseLayer layer;
  layer.inputs = checked_u32(features.size(), "features");
  layer.outputs = checked_u32(parameters, "transforms");
  for (std::size_t n = 0; n < parameters; ++n)
    for (std::size_t f = 0; f < features.size(); ++f) layer.weights.push_back(transforms[f * parameters + n]);
  layer.bias.assign(parameters, 0.0f);
  return {"skeleton", std::move(features), {std::move(layer)}};
}

Basis basis_by_bone(const Skeleton& skeleton, const std::vector<float>& columns) {
  const std::size_t vertices = skeleton.bones.size(), rows = 3 * vertices, count = columns.size() / rows;
  std::vector<std::uint32_t> order(vertices);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return skeleton.bones[a][0] < skeleton.bones[b][0]; });
  std::vector<float> sorted(columns.size());
  for (std::size_t c = 0; c < count; ++c)
    for (std::size_t i = 0; i < vertices; ++i)
      std::copy_n(columns.data() + c * rows + 3 * std::size_t(order[i]), 3, sorted.data() + c * rows + 3 * i);
  Basis basis = make_basis(checked_u32(rows, "coordinates"), checked_u32(count, "columns"), sorted);
  basis.order = std::move(order);
  return basis;
}

}  // namespace fb::bake
