#include "runtime/derivative/basis_rows.h"

#include <algorithm>

namespace fb::runtime {
namespace {

std::size_t block_of_row(const EvaluationLayout& layout, std::uint32_t row) {
  const auto after =
      std::upper_bound(layout.row_blocks.begin(), layout.row_blocks.end(), row,
                       [](std::uint32_t r, const RowBlockMatrix& block) { return r < block.first_row(); });
  return static_cast<std::size_t>(after - layout.row_blocks.begin()) - 1;
}

// What a level of detail multiplies a coefficient by.
float factor_at(const DetailChoice& choice, std::uint32_t column) {
  if (choice.level && !choice.level->uses(column)) return 0;
  return choice.next && !choice.next->uses(column) ? 1 - choice.share : 1;
}

void sort_and_unite(std::pmr::vector<std::uint32_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

BasisRows::BasisRows(const EvaluationLayout& layout, const DetailChoice& choice, const CsrTable<RowTerm>& sums,
                     std::pmr::memory_resource& memory)
    : length_(sums.row_offsets.size() - 1),
      coefficients_(&memory),
      values_(&memory),
      controls_(&memory),
      places_(&memory),
      parts_(&memory),
      derivatives_(&memory) {
  std::pmr::vector<std::uint32_t> blocks(&memory);
  for (const RowTerm& term : sums.entries) blocks.push_back(static_cast<std::uint32_t>(block_of_row(layout, term.row)));
  sort_and_unite(blocks);
  for (const std::uint32_t b : blocks)
    for (std::size_t c = 0; c < layout.row_blocks[b].column_count(); ++c)
      if (factor_at(choice, layout.row_blocks[b].column(c)) != 0)
        coefficients_.push_back(layout.row_blocks[b].column(c));
  sort_and_unite(coefficients_);
  for (std::uint32_t e = 0; e < layout.exact.count(); ++e)
    coefficients_.push_back(static_cast<std::uint32_t>(layout.coefficient_count) + e);
  values_.resize(coefficients_.size() * length_);
  std::pmr::vector<std::uint32_t> places(coefficient_and_pose_count(layout), UINT32_MAX, &memory);
  for (std::uint32_t k = 0; k < coefficients_.size(); ++k) places[coefficients_[k]] = k;
  const auto value_at = [&](std::size_t coefficient, std::size_t sum) {
    return places[coefficient] == UINT32_MAX ? nullptr : &values_[places[coefficient] * length_ + sum];
  };
  for (std::size_t sum = 0; sum < length_; ++sum)
    for (const RowTerm& term : sums.row(sum)) {
      const std::size_t b = block_of_row(layout, term.row);
      const RowBlockMatrix& block = layout.row_blocks[b];
      const std::uint32_t row = term.row - block.first_row();
      for (std::size_t c = 0; c < block.column_count(); ++c)
        if (float* const value = value_at(block.column(c), sum))
          *value += factor_at(choice, block.column(c)) * (term.weight * block.displacement(c, row));
      for (std::uint32_t e = 0; e < layout.exact.count(); ++e)
        *value_at(layout.coefficient_count + e, sum) += term.weight * layout.exact.correction(e, b, row);
    }
  // Those that move none of the sums are left out.
  std::size_t kept = 0;
  for (std::size_t k = 0; k < coefficients_.size(); ++k) {
    const auto first = values_.begin() + std::ptrdiff_t(k * length_);
    if (std::all_of(first, first + std::ptrdiff_t(length_), [](float value) { return value == 0; })) continue;
    if (kept < k) std::copy_n(first, length_, values_.begin() + std::ptrdiff_t(kept * length_));
    coefficients_[kept++] = coefficients_[k];
  }
  coefficients_.resize(kept);
  values_.resize(kept * length_);
  values_.shrink_to_fit();
}

// first, last: places in coefficients_.
bool BasisRows::uses(std::size_t sum, std::size_t first, std::size_t last) const {
  for (std::size_t k = first; k < last; ++k)
    if (values_[k * length_ + sum] != 0) return true;
  return false;
}

std::size_t BasisRows::count_using(std::uint32_t first, std::uint32_t last) const {
  const auto begin = std::lower_bound(coefficients_.begin(), coefficients_.end(), first) - coefficients_.begin();
  const auto end = std::lower_bound(coefficients_.begin(), coefficients_.end(), last) - coefficients_.begin();
  std::size_t count = 0;
  for (std::size_t sum = 0; sum < length_; ++sum)
    count += uses(sum, static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
  return count;
}

void BasisRows::move_region(std::uint32_t region, std::uint32_t first, std::uint32_t last, RegionSums& sums) {
  const auto begin = std::lower_bound(coefficients_.begin(), coefficients_.end(), first);
  const auto end = std::lower_bound(coefficients_.begin(), coefficients_.end(), last);
  const std::size_t from = begin - coefficients_.begin(), to = end - coefficients_.begin();
  for (std::uint32_t sum = 0; sum < length_; ++sum) {
    if (!uses(sum, from, to)) continue;
    parts_.push_back({region, static_cast<std::uint32_t>(sums.size() / (last - first)), sum, 0});
    sums.resize(sums.size() + last - first);
    for (std::size_t k = from; k < to; ++k)
      sums[sums.size() - (last - first) + coefficients_[k] - first] = values_[k * length_ + sum];
  }
  values_.erase(values_.begin() + std::ptrdiff_t(from * length_), values_.begin() + std::ptrdiff_t(to * length_));
  coefficients_.erase(begin, end);
}

void BasisRows::mark_used(std::span<std::uint8_t> used) const {
  for (const std::uint32_t coefficient : coefficients_) used[coefficient] = 1;
}

void BasisRows::find_controls(const CoefficientDerivatives& coefficients, std::span<const std::uint32_t> others) {
  controls_.assign(others.begin(), others.end());
  const auto add_controls = [&](std::span<const std::uint32_t> of) {
    controls_.insert(controls_.end(), of.begin(), of.end());
  };
  for (const std::uint32_t coefficient : coefficients_) add_controls(coefficients.controls(coefficient));
  for (const RegionPart& part : parts_) add_controls(coefficients.sum_controls(part.region));
  sort_and_unite(controls_);
  const auto add_places = [&](std::span<const std::uint32_t> of) {
    for (const std::uint32_t control : of)
      places_.push_back(static_cast<std::uint32_t>(std::lower_bound(controls_.begin(), controls_.end(), control) -
                                                   controls_.begin()));
  };
  for (const std::uint32_t coefficient : coefficients_) add_places(coefficients.controls(coefficient));
  for (std::size_t p = 0; p < parts_.size(); ++p) {  // parts of one region are next to each other
    const bool again = p > 0 && parts_[p - 1].region == parts_[p].region;
    parts_[p].first_place = again ? parts_[p - 1].first_place : static_cast<std::uint32_t>(places_.size());
    if (!again) add_places(coefficients.sum_controls(parts_[p].region));
  }
  derivatives_.resize(controls_.size() * length_);
}

void BasisRows::run(const PoseKernels& kernels, const CoefficientDerivatives& coefficients) {
  std::fill(derivatives_.begin(), derivatives_.end(), 0.0f);
  const std::uint32_t* place = places_.data();
  const float* values = values_.data();
  for (const std::uint32_t coefficient : coefficients_) {
    for (const float derivative : coefficients.of(coefficient)) {
      if (derivative != 0) kernels.add_rows(by_control(*place), &derivative, values, 0, 1, length_);
      ++place;
    }
    values += length_;
  }
  for (const RegionPart& part : parts_) {
    place = places_.data() + part.first_place;
    for (const float derivative : coefficients.of_sum(part.region, part.number))
      by_control(*place++)[part.sum] += derivative;
  }
}

}  // namespace fb::runtime
