#include "bake/analysis/blendshape_parts.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace fb::bake {
namespace {

using Key = std::tuple<std::uint32_t, std::uint32_t, float, float, float, std::uint32_t, std::uint32_t>;

Key key_of(const Feature& f) {
  return {static_cast<std::uint32_t>(f.kind), f.control, f.scale, f.threshold, f.fall, f.first, f.second};
}

bool composed(const Feature& feature) {
  return feature.kind == Feature::Kind::product || feature.kind == Feature::Kind::minimum;
}

// Calls add(feature), which returns its index, for the features a feature is composed of, then for itself.
template <class Add>
std::uint32_t import_with(std::span<const Feature> from, std::uint32_t index, const Add& add) {
  Feature feature = from[index];
  if (composed(feature)) {
    feature.first = import_with(from, from[index].first, add);
    feature.second = import_with(from, from[index].second, add);
    if (feature.second < feature.first) std::swap(feature.first, feature.second);
  }
  return add(feature);
}

}  // namespace

std::uint32_t add_feature(std::vector<Feature>& features, const Feature& feature) {
  for (std::size_t f = 0; f < features.size(); ++f)
    if (key_of(features[f]) == key_of(feature)) return static_cast<std::uint32_t>(f);
  features.push_back(feature);
  return static_cast<std::uint32_t>(features.size() - 1);
}

std::uint32_t import_feature(std::vector<Feature>& features, std::span<const Feature> from, std::uint32_t index) {
  return import_with(from, index, [&](const Feature& feature) { return add_feature(features, feature); });
}

SparseShape make_sparse(std::uint32_t feature, std::span<const float> offsets, double drop) {
  SparseShape shape{feature, {}, {}};
  for (std::size_t v = 0; v < offsets.size() / 3; ++v) {
    const float* d = offsets.data() + 3 * v;
    if (double(d[0]) * d[0] + double(d[1]) * d[1] + double(d[2]) * d[2] <= drop * drop) continue;
    shape.vertices.push_back(static_cast<std::uint32_t>(v));
    shape.offsets.insert(shape.offsets.end(), d, d + 3);
  }
  return shape;
}

std::vector<std::vector<std::uint32_t>> append(SparseBlendshapes& base,
                                               std::span<const SparseBlendshapes* const> parts) {
  std::map<Key, std::uint32_t> known;  // thousands of features: found by key
  for (std::size_t f = 0; f < base.features.size(); ++f)
    known.emplace(key_of(base.features[f]), static_cast<std::uint32_t>(f));
  const auto add = [&](const Feature& feature) {
    const auto [entry, fresh] = known.emplace(key_of(feature), static_cast<std::uint32_t>(base.features.size()));
    if (fresh) base.features.push_back(feature);
    return entry->second;
  };
  std::vector<std::vector<std::uint32_t>> carried(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (SparseShape shape : parts[p]->shapes) {
      shape.feature = import_with(parts[p]->features, shape.feature, add);
      carried[p].push_back(shape.feature);
      base.shapes.push_back(std::move(shape));
    }
  return carried;
}

std::size_t stored_offsets(const SparseBlendshapes& base) {
  std::size_t count = 0;
  for (const SparseShape& shape : base.shapes) count += shape.offsets.size();
  return count;
}

}  // namespace fb::bake
