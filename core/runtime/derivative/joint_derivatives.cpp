#include "runtime/derivative/joint_derivatives.h"

#include <algorithm>
#include <iterator>

namespace fb::runtime {
namespace {

// A number and its derivatives by some of the numbers that it is made of.
struct DualNumber {
  static constexpr std::size_t count = 4;
  using Rates = float __attribute__((vector_size(4 * count)));
  DualNumber() = default;
  explicit DualNumber(float constant) : value(constant) {}
  DualNumber(float at, const Rates& of) : value(at), rates(of) {}
  friend DualNumber operator+(const DualNumber& a, const DualNumber& b) {
    return {a.value + b.value, a.rates + b.rates};
  }
  friend DualNumber operator-(const DualNumber& a, const DualNumber& b) {
    return {a.value - b.value, a.rates - b.rates};
  }
  friend DualNumber operator-(const DualNumber& a) { return {-a.value, -a.rates}; }
  friend DualNumber operator*(const DualNumber& a, const DualNumber& b) {
    return {a.value * b.value, a.rates * b.value + a.value * b.rates};
  }
  friend bool operator<(const DualNumber& a, const DualNumber& b) { return a.value < b.value; }
  // Numbers that are 0 and cannot become anything else are equal to 0.
  friend bool operator!=(const DualNumber& a, const DualNumber& b) {
    for (std::size_t i = 0; i < count; ++i)
      if (a.rates[i] != b.rates[i]) return true;
    return a.value != b.value;
  }
  float value = 0;
  Rates rates = {};
};

std::size_t padded_count(std::size_t count) {
  return (count + padding - 1) / padding * padding;
}

// One sum a number of the joint.
CsrTable<RowTerm> sums_of_numbers(const EvaluationLayout& layout, const DrivenSkin::Joint& joint,
                                  std::pmr::memory_resource& memory) {
  const std::uint32_t count = joint.end_row - joint.first_row;
  CsrTable<RowTerm> sums(memory);
  CsrBuilder<RowTerm> builder(padded_count(count), count, memory);
  for (std::uint32_t k = 0; k < count; ++k)
    builder.add(k, {joint.first_row + k, layout.skin.scale(joint.first_row + k)});
  builder.build(sums);
  return sums;
}

std::uint32_t place_in(std::span<const std::uint32_t> controls, std::uint32_t control) {
  const auto at = std::lower_bound(controls.begin(), controls.end(), control);
  return at != controls.end() && *at == control ? static_cast<std::uint32_t>(at - controls.begin()) : UINT32_MAX;
}

}  // namespace

JointDerivatives::WantedJoint::WantedJoint(const EvaluationLayout& layout, const DetailChoice& choice,
                                           std::uint32_t joint, std::pmr::memory_resource& memory)
    : number(joint),
      numbers(layout, choice, sums_of_numbers(layout, layout.skin.joint(joint), memory), memory),
      values(layout.skin.joint(joint).end_row - layout.skin.joint(joint).first_row, &memory),
      controls(&memory),
      derivatives(&memory),
      of_parent(&memory),
      of_numbers(&memory),
      by_number(values.size(), &memory) {}

JointDerivatives::JointDerivatives(const EvaluationLayout& layout, const DetailChoice& choice,
                                   std::span<const std::uint8_t> wanted, std::pmr::memory_resource& memory)
    : layout_(layout), state_(layout.skin, memory), joints_(&memory), places_(layout.skin.joint_count(), &memory) {
  std::pmr::vector<std::uint8_t> marks(wanted.begin(), wanted.end(), &memory);
  for (std::size_t j = marks.size(); j > 0; --j)
    if (marks[j - 1] && layout.skin.joint(j - 1).parent != no_joint) marks[layout.skin.joint(j - 1).parent] = 1;
  joints_.reserve(static_cast<std::size_t>(std::count(marks.begin(), marks.end(), 1)));
  for (std::uint32_t j = 0; j < marks.size(); ++j) {
    if (!marks[j]) continue;
    places_[j] = static_cast<std::uint32_t>(joints_.size());
    joints_.emplace_back(layout, choice, j, memory);
  }
}

void JointDerivatives::find_controls(const CoefficientDerivatives& coefficients) {
  for (WantedJoint& joint : joints_) {
    joint.numbers.find_controls(coefficients, {});
    const std::uint32_t parent = layout_.skin.joint(joint.number).parent;
    const auto own = joint.numbers.controls();
    const auto of_parent = parent == no_joint ? std::span<const std::uint32_t>() : controls(parent);
    std::set_union(own.begin(), own.end(), of_parent.begin(), of_parent.end(), std::back_inserter(joint.controls));
    for (const std::uint32_t control : joint.controls) {
      joint.of_parent.push_back(place_in(of_parent, control));
      joint.of_numbers.push_back(place_in(own, control));
    }
    joint.derivatives.resize(joint.controls.size());
  }
}

Change<float> JointDerivatives::change(std::size_t joint) const {
  Change<float> change;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column)
      change[4 * row + column] = state_.matrices[joint].numbers[4 * column + row];
  return change;
}

void JointDerivatives::find_changes(const float* rows) {
  if (joints_.empty()) return;
  layout_.skin.find_matrices(rows, state_);
  for (WantedJoint& joint : joints_) {
    const std::uint32_t first = layout_.skin.joint(joint.number).first_row;
    for (std::uint32_t k = 0; k < joint.values.size(); ++k)
      joint.values[k] = layout_.skin.scale(first + k) * rows[first + k];
  }
}

// What the joint does by itself, and its derivative by each of its numbers.
void JointDerivatives::find_own_derivatives(WantedJoint& joint) const {
  const DrivenSkin::Joint& form = layout_.skin.joint(joint.number);
  for (std::size_t first = 0; first < joint.values.size(); first += DualNumber::count) {
    std::size_t at = 0;
    const auto next = [&] {
      DualNumber number(joint.values[at]);
      if (at >= first && at < first + DualNumber::count) number.rates[at - first] = 1;
      ++at;
      return number;
    };
    const Change<DualNumber> change =
        change_of_joint<DualNumber>(form.rest, form.numbers, layout_.skin.outer_rotations(form), next);
    const std::size_t end = std::min(first + DualNumber::count, joint.values.size());
    for (std::size_t i = 0; i < change.size(); ++i) {
      joint.own[i] = change[i].value;
      for (std::size_t k = first; k < end; ++k) joint.by_number[k][i] = change[i].rates[k - first];
    }
  }
}

void JointDerivatives::run(const PoseKernels& kernels, const CoefficientDerivatives& coefficients) {
  for (WantedJoint& joint : joints_) {
    joint.numbers.run(kernels, coefficients);
    find_own_derivatives(joint);
    const std::uint32_t parent = layout_.skin.joint(joint.number).parent;
    const Change<float> above = parent == no_joint ? Change<float>{} : change(parent);
    for (std::size_t c = 0; c < joint.derivatives.size(); ++c) {
      Change<float> own_rate = {};
      if (joint.of_numbers[c] != UINT32_MAX) {
        const float* const rates = joint.numbers.by_control(joint.of_numbers[c]);
        for (std::size_t k = 0; k < joint.values.size(); ++k)
          for (std::size_t i = 0; i < own_rate.size() && rates[k] != 0; ++i)
            own_rate[i] += rates[k] * joint.by_number[k][i];
      }
      // Of (above + own) + above x own.
      Change<float>& rate = joint.derivatives[c];
      for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column)
          rate[4 * row + column] = own_rate[4 * row + column] + times(&above[4 * row], own_rate, column);
      if (joint.of_parent[c] == UINT32_MAX) continue;
      const Change<float>& above_rate = derivative(parent, joint.of_parent[c]);
      for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column)
          rate[4 * row + column] += above_rate[4 * row + column] + times(&above_rate[4 * row], joint.own, column);
    }
  }
}

}  // namespace fb::runtime
