#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/derivative/feature_derivatives.h"
#include "runtime/derivative/region_derivative.h"
#include "runtime/evaluation_layout.h"

namespace fb::runtime {

// What rows of the basis are multiplied by: the coefficients of its columns, and behind them the weights of exact
// poses.
inline std::size_t coefficient_and_pose_count(const EvaluationLayout& layout) {
  return layout.coefficient_count + layout.exact.count();
}

// The weights of sums of a region's coefficients, one a coefficient of each sum.
using RegionSums = std::pmr::vector<float>;

// Their derivatives by the controls in a pose.
class CoefficientDerivatives {
 public:
  // used: which of them are wanted; sums: by region, sums whose derivatives are wanted, too.
  CoefficientDerivatives(const EvaluationLayout& layout, std::span<const std::uint8_t> used,
                         std::span<const RegionSums> sums, std::pmr::memory_resource& memory);

  // See FeatureDerivatives::run.
  void run(const float* controls, const std::uint8_t* downwards);

  // The controls that a coefficient that is used depends on, ascending, and its derivative by each.
  std::span<const std::uint32_t> controls(std::size_t coefficient) const;
  std::span<const float> of(std::size_t coefficient) const;
  // Those of a sum.
  std::span<const std::uint32_t> sum_controls(std::size_t region) const { return regions_[region].controls(); }
  std::span<const float> of_sum(std::size_t region, std::size_t sum) const { return regions_[region].of(sum); }

 private:
  std::size_t region_of(std::size_t coefficient) const;

  const EvaluationLayout& layout_;
  FeatureDerivatives features_;
  std::pmr::vector<RegionDerivative> regions_;
  std::pmr::vector<std::uint32_t> sum_numbers_;   // by coefficient that is used: its sum in its region
  std::pmr::vector<std::uint32_t> all_controls_;  // what weights of exact poses depend on
  std::pmr::vector<float> of_exact_;              // exact poses x controls
  ExactBlend::State exact_;
};

}  // namespace fb::runtime
