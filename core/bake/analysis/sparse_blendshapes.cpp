#include "bake/analysis/sparse_blendshapes.h"

#include "base/status.h"
#include "model/feature_values.h"

namespace fb::bake {

// Runs of consecutive vertices, as most are, are one contiguous loop.
void add_scaled(const SparseShape& shape, float value, std::span<float> displacement) {
  const std::size_t count = shape.vertices.size();
  for (std::size_t first = 0; first < count;) {
    const std::uint32_t start = shape.vertices[first];
    std::size_t last = first + 1;
    while (last < count && shape.vertices[last] - start == last - first) ++last;
    const float* from = shape.offsets.data() + 3 * first;
    float* to = displacement.data() + std::size_t{3} * start;
    for (std::size_t i = 0; i < 3 * (last - first); ++i) to[i] += value * from[i];
    first = last;
  }
}

void evaluate_features(std::span<const Feature> features, std::span<const float> controls, std::span<const float> rest,
                       std::span<float> values) {
  feature_values(features, controls.data(), rest.data(), values.data());
}

void SparseBlendshapes::add(std::span<const float> controls, std::span<const float> rest, std::size_t count, float sign,
                            std::span<float> displacements) const {
  if (count == 0) return;
  if (controls.size() != count * rest.size() || displacements.size() % count != 0)
    fail(Status::invalid_argument, "%zu poses of %zu controls need %zu values, not %zu", count, rest.size(),
         count * rest.size(), controls.size());
  const std::size_t size = displacements.size() / count;
  std::vector<float> values(features.size());
  for (std::size_t i = 0; i < count; ++i) {
    evaluate_features(features, controls.subspan(i * rest.size(), rest.size()), rest, values);
    for (const SparseShape& shape : shapes)
      if (const float value = values[shape.feature]; value != 0)
        add_scaled(shape, sign * value, displacements.subspan(i * size, size));
  }
}

SparseBlendshapes part_of(const SparseBlendshapes& blendshapes, std::span<const std::uint32_t> vertices) {
  SparseBlendshapes part{blendshapes.features, {}};
  for (const SparseShape& shape : blendshapes.shapes) {
    SparseShape some{shape.feature, {}, {}};
    std::size_t at = 0;
    for (std::uint32_t v = 0; v < vertices.size(); ++v) {
      while (at < shape.vertices.size() && shape.vertices[at] < vertices[v]) ++at;
      if (at == shape.vertices.size()) break;
      if (shape.vertices[at] != vertices[v]) continue;
      some.vertices.push_back(v);
      some.offsets.insert(some.offsets.end(), &shape.offsets[3 * at], &shape.offsets[3 * at] + 3);
    }
    if (!some.vertices.empty()) part.shapes.push_back(std::move(some));
  }
  return part;
}

std::vector<FeatureUsage> feature_usage(const std::vector<Feature>& features, const RigSchema& schema,
                                        std::span<const float> controls) {
  const std::vector<float> rest = schema.rest_pose();
  const std::size_t poses = controls.size() / rest.size();
  std::vector<FeatureUsage> uses(features.size());
  std::vector<float> values(features.size());
  for (std::size_t pose = 0; pose < poses; ++pose) {
    evaluate_features(features, controls.subspan(pose * rest.size(), rest.size()), rest, values);
    for (std::size_t f = 0; f < values.size(); ++f) {
      uses[f].square += double(values[f]) * values[f] / static_cast<double>(poses);
      uses[f].active += (values[f] != 0) / static_cast<double>(poses);
    }
  }
  return uses;
}

}  // namespace fb::bake
