// Eyes and lids: the lids turn about the eyeball, follow the look, meet, and do not pass through each other.
#pragma once

#include <array>
#include <vector>

#include "production/sliding_bones.h"

namespace rigs::production {

class LidBones {
 public:
  LidBones(ControlList& controls, std::vector<FaceBone>& bones);

  // After the brows and cheeks.
  void pose(const float* c, const SlidingBones& skin, std::vector<Motion>& motions) const;

 private:
  static constexpr std::size_t lid_count = 5;
  struct Lid {
    Vec head;
    std::vector<int> channels;  // ty, tz
    std::size_t bone;
  };
  struct Eye {
    int side;
    std::vector<int> look;  // degrees down, to the left
    int blink, wide, squint, twist;
    std::array<Lid, lid_count> upper, lower;  // from the nose outwards
  };

  void add_eye(ControlList& controls, std::vector<FaceBone>& bones, Eye& eye);

  Eye eyes_[2];
  int look_x_, look_y_;
};

}  // namespace rigs::production
