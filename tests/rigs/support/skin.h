// Linear blend skinning with sparse weights: the last step of both rigs, and where nearly all their time goes.
#pragma once

#include <cstdint>
#include <vector>

#include "support/rig_folder.h"

namespace rigs {

// What a joint adds to a point, beyond leaving it where it is: offset = D * [point; 1], the 3x4 matrix D in columns,
// one after the other. All zeros is a joint at rest, so that a rig at rest gives its rest mesh bit by bit.
struct JointOffset {
  float columns[12];
};

class Skin {
 public:
  // weights: [V, joints].
  explicit Skin(const Array<float>& weights);

  std::size_t vertices() const { return first_.size() - 1; }
  std::size_t joints() const { return used_.size(); }
  // Whether any vertex follows this joint.
  bool uses(std::size_t joint) const { return used_[joint]; }
  // positions = points + sum over joints of weight * offset; both 3 x V. One offset a joint; unused ones are not read.
  void apply(const JointOffset* joints, const float* points, float* positions) const;

 private:
  std::vector<bool> used_;
  std::vector<std::uint32_t> first_;  // of a vertex's run in joint_ and weight_; V + 1
  std::vector<std::uint32_t> joint_;
  std::vector<float> weight_;
};

}  // namespace rigs
