#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/csr_table.h"
#include "runtime/derivative/coefficient_derivatives.h"
#include "runtime/evaluation_layout.h"

namespace fb::runtime {

// A part of a weighted sum of rows of the basis.
struct RowTerm {
  std::uint32_t row;
  float weight;
};

// Weighted sums of rows of the basis, as floats, and their derivatives by the controls in a pose.
class BasisRows {
 public:
  // sums: one of each row of the table, whose number of rows is a multiple of `padding`; choice: the level of detail.
  BasisRows(const EvaluationLayout& layout, const DetailChoice& choice, const CsrTable<RowTerm>& sums,
            std::pmr::memory_resource& memory);

  // How many of the sums use coefficients first..last - 1.
  std::size_t count_using(std::uint32_t first, std::uint32_t last) const;
  // Adds what these sums take of the coefficients of a region, first..last - 1, to `sums`, to be used instead of them.
  void move_region(std::uint32_t region, std::uint32_t first, std::uint32_t last, RegionSums& sums);
  // Marks the coefficients that they use.
  void mark_used(std::span<std::uint8_t> used) const;
  // To be called once, with derivatives of all that are used. others: controls that derivatives are kept of, too.
  void find_controls(const CoefficientDerivatives& coefficients, std::span<const std::uint32_t> others);
  void run(const PoseKernels& kernels, const CoefficientDerivatives& coefficients);

  std::size_t length() const { return length_; }  // sums
  // The controls that they depend on, and others, ascending.
  std::span<const std::uint32_t> controls() const { return controls_; }
  // The derivatives of all sums by controls()[index].
  float* by_control(std::size_t index) { return derivatives_.data() + index * length_; }
  const float* by_control(std::size_t index) const { return derivatives_.data() + index * length_; }

 private:
  // The part of a sum that is a sum of a region's coefficients.
  struct RegionPart {
    std::uint32_t region, number, sum;
    std::uint32_t first_place;  // in places_
  };

  bool uses(std::size_t sum, std::size_t first, std::size_t last) const;

  std::size_t length_;
  std::pmr::vector<std::uint32_t> coefficients_;       // ascending
  std::pmr::vector<float> values_;                     // of each, length_
  std::pmr::vector<std::uint32_t> controls_, places_;  // places_: in controls_, of those of each coefficient
  std::pmr::vector<RegionPart> parts_;
  std::pmr::vector<float> derivatives_;
};

}  // namespace fb::runtime
