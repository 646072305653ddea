#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/derivative/basis_rows.h"
#include "runtime/evaluation_layout.h"
#include "runtime/joint_change.h"

namespace fb::runtime {

// What driven joints do in a pose, and how that changes with the controls.
class JointDerivatives {
 public:
  // wanted: joints; their parents are added.
  JointDerivatives(const EvaluationLayout& layout, const DetailChoice& choice, std::span<const std::uint8_t> wanted,
                   std::pmr::memory_resource& memory);

  // All rows of the basis that are needed.
  template <class Visit>
  void visit_rows(const Visit& visit) {
    for (WantedJoint& joint : joints_) visit(joint.numbers);
  }
  // To be called once.
  void find_controls(const CoefficientDerivatives& coefficients);

  // The values alone; rows: positions of a pose in baked order, with those that carry numbers.
  void find_changes(const float* rows);
  // The derivatives, after the values of the same pose.
  void run(const PoseKernels& kernels, const CoefficientDerivatives& coefficients);

  // Whether a joint, which is wanted, is not still.
  bool moves(std::size_t joint) const { return state_.moved[joint] != 0; }
  Change<float> change(std::size_t joint) const;
  // The controls that a joint that is wanted depends on, ascending, and the derivative of its change by each.
  std::span<const std::uint32_t> controls(std::size_t joint) const { return joints_[places_[joint]].controls; }
  const Change<float>& derivative(std::size_t joint, std::size_t control) const {
    return joints_[places_[joint]].derivatives[control];
  }

 private:
  struct WantedJoint {
    WantedJoint(const EvaluationLayout& layout, const DetailChoice& choice, std::uint32_t joint,
                std::pmr::memory_resource& memory);
    std::uint32_t number;
    BasisRows numbers;
    std::pmr::vector<float> values;  // of numbers
    std::pmr::vector<std::uint32_t> controls;
    std::pmr::vector<Change<float>> derivatives;  // by control
    // By control: its place in the list of the parent, and in that of the numbers; UINT32_MAX: it is not there.
    std::pmr::vector<std::uint32_t> of_parent, of_numbers;
    Change<float> own = {};                     // what it does by itself
    std::pmr::vector<Change<float>> by_number;  // the derivative of that
  };
  void find_own_derivatives(WantedJoint& joint) const;

  const EvaluationLayout& layout_;
  DrivenSkin::State state_;
  std::pmr::vector<WantedJoint> joints_;    // parents come first
  std::pmr::vector<std::uint32_t> places_;  // by joint: in joints_
};

}  // namespace fb::runtime
