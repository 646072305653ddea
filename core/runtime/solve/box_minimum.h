#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "runtime/solve/cholesky.h"

namespace fb::runtime {

// The step d that minimises g d + d H d / 2 between bounds. By block principal pivoting (Judice and Pires, Computers
// and Operations Research 21, 1994): every unknown is free or held at a bound; the free ones are found; all that are
// then beyond a bound are held at it, and all held ones that would rather leave it are freed, until there are none.
class BoxMinimum {
 public:
  enum class Held : std::uint8_t { free, low, high };

  BoxMinimum(std::size_t most, const PoseKernels& kernels, std::pmr::memory_resource& memory);

  std::size_t row_stride() const { return factor_.row_stride(); }
  // The system to be filled, of `count` unknowns: the lower triangle of H, and g.
  float* matrix() { return matrix_.data(); }
  float* gradient() { return gradient_.data(); }
  // By unknown; a step may be 0.
  float* lower() { return lower_.data(); }
  float* upper() { return upper_.data(); }

  // By unknown, where it is thought to be held, and after solve() where it is: a good guess saves time.
  Held* held() { return held_.data(); }

  // To be called where the matrix is another one, or the damping: that times its diagonal is added to it.
  void set_matrix(std::size_t count, float damping);
  // Finds the step. False where H is not positive definite.
  bool solve();
  const float* step() const { return step_.data(); }
  // By how much the step lowers g d + d H d / 2.
  double decrease() const;
  // The diagonal of the inverse of H, as step(). False where H is not positive definite.
  bool find_variances();

 private:
  void guess_held();
  bool factorise_free();
  bool find_free();
  bool belongs_elsewhere(std::size_t unknown, Held& to) const;

  const PoseKernels& kernels_;
  Cholesky factor_;
  std::pmr::vector<float> matrix_, gradient_, lower_, upper_, step_;
  std::pmr::vector<float> whole_;   // H with both triangles and damping
  std::pmr::vector<float> slopes_;  // g + H d
  std::pmr::vector<Held> held_;
  std::size_t count_ = 0;
  std::pmr::vector<std::uint32_t> free_, factorised_;  // factorised_: those whose part of H has a factor
  std::pmr::vector<float> right_;
};

}  // namespace fb::runtime
