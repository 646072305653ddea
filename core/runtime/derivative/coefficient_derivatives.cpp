#include "runtime/derivative/coefficient_derivatives.h"

#include <algorithm>
#include <numeric>

namespace fb::runtime {

CoefficientDerivatives::CoefficientDerivatives(const EvaluationLayout& layout, std::span<const std::uint8_t> used,
                                               std::span<const RegionSums> sums, std::pmr::memory_resource& memory)
    : layout_(layout),
      features_(layout.features, memory),
      regions_(&memory),
      sum_numbers_(layout.coefficient_count, &memory),
      all_controls_(layout.exact.empty() ? 0 : layout.features.control_count(), &memory),
      of_exact_(layout.exact.count() * layout.features.control_count(), &memory),
      exact_(layout.exact, 1, memory) {
  std::iota(all_controls_.begin(), all_controls_.end(), 0u);
  regions_.reserve(layout.networks.size());
  for (std::size_t r = 0; r < layout.networks.size(); ++r) {
    const std::size_t outputs = layout.networks[r].output_count();
    RegionSums all(sums[r], &memory);
    for (std::uint32_t c = layout.coefficient_offsets[r]; c < layout.coefficient_offsets[r + 1]; ++c) {
      if (!used[c]) continue;
      sum_numbers_[c] = static_cast<std::uint32_t>(all.size() / outputs);
      all.resize(all.size() + outputs);
      all[all.size() - outputs + c - layout.coefficient_offsets[r]] = 1;
    }
    regions_.emplace_back(layout, r, features_, all, memory);
  }
}

void CoefficientDerivatives::run(const float* controls, const std::uint8_t* downwards) {
  features_.run(layout_.kernels, controls, downwards);
  for (RegionDerivative& region : regions_) region.run(layout_.kernels, features_);
  if (!layout_.exact.empty()) layout_.exact.find_weight_derivatives(controls, exact_, of_exact_.data());
}

std::size_t CoefficientDerivatives::region_of(std::size_t coefficient) const {
  const auto& offsets = layout_.coefficient_offsets;
  return static_cast<std::size_t>(std::upper_bound(offsets.begin(), offsets.end(), coefficient) - offsets.begin()) - 1;
}

std::span<const std::uint32_t> CoefficientDerivatives::controls(std::size_t coefficient) const {
  if (coefficient < layout_.direct.size()) return features_.controls(layout_.direct[coefficient]);
  if (coefficient < layout_.coefficient_count) return regions_[region_of(coefficient)].controls();
  return all_controls_;
}

std::span<const float> CoefficientDerivatives::of(std::size_t coefficient) const {
  if (coefficient < layout_.direct.size()) return features_.of(layout_.direct[coefficient]);
  if (coefficient < layout_.coefficient_count) return regions_[region_of(coefficient)].of(sum_numbers_[coefficient]);
  return std::span(of_exact_).subspan((coefficient - layout_.coefficient_count) * all_controls_.size(),
                                      all_controls_.size());
}

}  // namespace fb::runtime
