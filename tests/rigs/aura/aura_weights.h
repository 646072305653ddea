// From Aura's controls to the weights of its 267 shapes: the controls themselves, in-betweens and combinations.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace rigs {

class AuraWeights {
 public:
  // From the text of rig.json; throws where it is not as expected.
  explicit AuraWeights(const std::string& rig_json);

  std::size_t controls() const { return controls_; }
  std::size_t size() const { return controls_ + first_.size() - 1; }
  // controls() floats in, size() weights out.
  void evaluate(const float* controls, double* weights) const;

 private:
  // A factor of a product: the control's value, or a tent over it, 0 at x1, 1 at x2, 0 at x3 (1 up to x3 if x2 == x3).
  struct Term {
    std::size_t control;
    bool tent;
    double x1, x2, x3;
  };

  void add_term(std::size_t control, bool tent, double x1, double x2, double x3);

  std::size_t controls_;
  std::vector<Term> terms_;
  std::vector<std::size_t> first_{0};  // of a product's run in terms_; one more than products
};

}  // namespace rigs
