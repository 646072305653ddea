#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fb::bake {

// Two controls that turn a joint, a < b: what is left of both together, squared, if the joint turns by the sum of their
// vectors, by that of a and then that of b, and the other way round.
struct PairOfTurns {
  std::uint32_t a = 0, b = 0;
  double summed = 0, a_first = 0, b_first = 0;
};

// The order in which controls turn a joint: the one that leaves least, as far as moving single controls within it finds
// it.
class JointOrder {
 public:
  // Of pairs that are not given, the order does not matter.
  explicit JointOrder(std::span<const PairOfTurns> pairs);

  // The controls of consecutive rotations, from the inside out, which are each summed: as few as leave `enough` in
  // all, or `most`, cut where the least is left.
  std::vector<std::vector<std::uint32_t>> rotations(double enough, std::size_t most) const;

  // What is left of the pairs in this order, each control being a rotation of its own.
  double left() const;

 private:
  void insert(std::size_t control);
  std::vector<double> left_within() const;

  std::vector<std::uint32_t> controls_;   // ascending
  std::vector<double> first_, together_;  // controls x controls: what is left with the row first, and summed
  std::vector<std::size_t> order_;        // of controls_, the innermost first
};

}  // namespace fb::bake
