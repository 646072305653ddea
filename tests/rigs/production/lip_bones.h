// Sixteen bones round the mouth: own channels, channels of the whole mouth, shares of the jaw, limits, sliding on the
// teeth, a zipper, lips that do not pass through each other, and bones that track and stretch to their neighbours.
#pragma once

#include <array>
#include <vector>

#include "production/jaw_bones.h"

namespace rigs::production {

class LipBones {
 public:
  static constexpr int count = 16, upper = 0, lower = 7, left_corner = 14, right_corner = 15;

  LipBones(ControlList& controls, std::vector<FaceBone>& bones);

  void pose(const JawBones& jaw, const float* c, std::vector<Motion>& motions) const;
  std::size_t first_bone() const { return first_; }

 private:
  struct Lip {
    Vec head;
    int row;                    // 1 upper, -1 lower, 0 a corner
    int side;                   // 1 left, -1 right, 0 the middle
    float jaw;                  // share of the jaw's motion
    int inward, outward;        // neighbours
    std::vector<int> channels;  // tx, ty, tz, roll
  };
  struct Shape {
    Vec head;
    float roll;
  };

  void add_lips(ControlList& controls, std::vector<FaceBone>& bones);
  Vec moved_by_mouth(const Lip& lip, const float* c) const;
  Shape shape(const Lip& lip, const float* c) const;
  void zip(const float* c, std::array<Vec, count>& heads) const;
  void part(const JawBones& jaw, const float* c, std::array<Vec, count>& heads) const;

  struct Sided {
    int left, right;
  };
  static float weighted(const Sided& control, const Lip& lip, const float* c);

  std::array<Lip, count> lips_;
  std::size_t first_;
  std::vector<int> mouth_;
  int turn_, pucker_, funnel_, press_, upper_roll_, lower_roll_;
  Sided smile_, frown_, stretch_, upper_up_, lower_down_, zip_;
};

}  // namespace rigs::production
