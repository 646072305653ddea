#include "bake/analysis/feature_usage.h"

#include "bake/analysis/sparse_blendshapes.h"

namespace fb::bake {

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
