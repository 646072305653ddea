// Bones under the skin of brows, forehead, cheeks, nose and chin: each has channels, follows other bones, stays within
// a distance of where it is carried, slides over the skull, and may turn to keep looking at a bone.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "production/jaw_bones.h"

namespace rigs::production {

class SlidingBones {
 public:
  // lips: the first of the sixteen bones of the mouth.
  SlidingBones(ControlList& controls, std::vector<FaceBone>& bones, std::size_t lips);

  void pose(const JawBones& jaw, const float* c, std::vector<Motion>& motions) const;
  // The height that the brow of a side has over its rest pose.
  float brow_height(int side, const std::vector<Motion>& motions) const;

 private:
  struct Driver {
    int control;
    Vec offset;  // at the control's value 1
  };
  struct Bone {
    std::size_t bone = 0;
    Vec head;
    int side = 0;
    std::vector<int> channels;
    std::vector<Driver> drivers;
    std::vector<std::pair<std::size_t, float>> follows;  // bones, and shares of how far they moved
    float jaw = 0, limit = 1.3f;
    int target = -1;  // bone it looks at
  };

  Bone& add(ControlList& controls, std::vector<FaceBone>& bones, std::string_view name, std::string_view group,
            Vec head, int side, float reach, float range);
  void add_brows(ControlList& controls, std::vector<FaceBone>& bones, int side);
  void add_cheeks(ControlList& controls, std::vector<FaceBone>& bones, int side, std::size_t lips);
  void add_middle(ControlList& controls, std::vector<FaceBone>& bones, std::size_t lips);

  std::vector<Bone> bones_;
  std::size_t brows_[2] = {};  // the middle bone of either brow: left, right
};

}  // namespace rigs::production
