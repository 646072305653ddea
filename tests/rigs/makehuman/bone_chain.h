// MakeHuman's bones: rotations of pose units and of single bones, composed down the chain.
#pragma once

#include <cstddef>
#include <vector>

#include "support/skin.h"

namespace rigs {

// Angles are radians. A bone's rotation is the product of its units' rotations, later units on the left, then the
// bone's own Euler angles Rz * Ry * Rx on the left of those; it turns about the bone's head and what hangs below
// follows.
class BoneChain {
 public:
  // parents: one a bone, before its children; -1: none. unit_rotations: [units, bones, 3], axis * angle at unit
  // weight 1. face_bones: the bones that have Euler angles; heads: at rest, 3 x bones. Bones that neither carry skin
  // nor lead to one that does are left out.
  BoneChain(const std::vector<int>& parents, const Array<float>& unit_rotations,
            const std::vector<std::size_t>& face_bones, const std::vector<float>& heads, const Skin& skin);

  // The bones that are not left out, by their number among all bones; the number of each one's parent among them, or
  // -1; and whether any rotation moves it.
  std::size_t count() const { return bones_.size(); }
  std::size_t index(std::size_t bone) const { return bones_[bone].index; }
  std::ptrdiff_t parent(std::size_t bone) const { return bones_[bone].parent; }
  bool turns(std::size_t bone) const { return bones_[bone].face >= 0 || !bones_[bone].units.empty(); }

  // units: one weight each; angles: x, y, z a face bone; heads: 3 x bones, about which they turn; offsets: one a bone,
  // written where skin is. frames: of the bones that are not left out, 12 each, which were at their heads at rest and
  // moved as vertices do; null: none.
  void evaluate(const float* units, const double* angles, const float* heads, JointOffset* offsets,
                float* frames = nullptr) const;

 private:
  struct UnitRotation {
    std::size_t unit;
    double axis[3];
    double angle;
  };
  struct Bone {
    std::size_t index;      // among all bones
    std::ptrdiff_t parent;  // in bones_; -1: none
    std::ptrdiff_t face;    // among face bones; -1: none
    bool skinned;
    std::vector<UnitRotation> units;
  };

  std::vector<float> rest_heads_;
  std::vector<Bone> bones_;
};

}  // namespace rigs
