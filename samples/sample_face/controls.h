// The controls of the sample face. All rest at 0 and range over [0, 1] or [-1, 1].
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

namespace sample_face {

struct Control {
  std::string name, group;
  bool two_sided = false;  // range [-1, 1]; otherwise [0, 1]
};

class Controls {
 public:
  // Returns the new control's index.
  int add(std::string name, std::string group, bool two_sided);
  // Index by name; throws std::out_of_range naming the control if there is none.
  int index(const std::string& name) const;
  const std::vector<Control>& list() const { return list_; }

 private:
  std::vector<Control> list_;
  std::unordered_map<std::string, int> indices_;
};

// Indices of the controls that turn, slide and stick rather than add shapes; [2] is left, right.
struct MotionControls {
  int jaw_open, jaw_side, jaw_forward, jaw_twist;
  int look_x, look_y, eye_yaw[2], eye_pitch[2], eye_out[2], pupil[2];
  int blink[2], upper_lid[2], lower_lid[2], lid_tilt[2];
  int lid_up[2][2][5], lid_thick[2][2][5];  // eye, upper/lower, segment from the outer corner to the inner
  int roll[2], roll_side[2][2];             // upper/lower; and left/right
  int curl[2];
  int lip_turn[2][11], lip_full[2][11];  // upper/lower, segment from the right corner to the left
  int zip[2], stick, lips_together, mouth_swing, mouth_twist;
  int tongue_out, tongue_pitch[4], tongue_yaw[4], tongue_twist, tongue_wide, tongue_gutter;
  int squash, bend;
};

MotionControls add_motion_controls(Controls& controls);

// "L1" left of the middle, "M", "R1", ...: names of a row of segments from right to left.
std::string segment_name(int segment, int count);

}  // namespace sample_face
