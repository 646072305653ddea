// The controls of the production rig: channels of bones, and a few of whole parts of the face.
#pragma once

#include <string>
#include <vector>

#include "production/rig_math.h"

namespace rigs::production {

struct ControlRange {
  std::string name, group;
  float minimum, maximum;  // the rest value is 0
};

class ControlList {
 public:
  int add(const std::string& name, const std::string& group, float minimum, float maximum);
  // One index for each letter of `axes`, named NAME.tx and so on; the range is symmetrical.
  std::vector<int> add_channels(const std::string& name, const std::string& group, const std::string& axes,
                                float reach);
  // Throws std::out_of_range where there is no such control.
  int index(const std::string& name) const;
  const std::vector<ControlRange>& list() const { return list_; }

 private:
  std::vector<ControlRange> list_;
};

// Names of the sides: "_L" is +x.
inline const char* side_name(int side) {
  return side > 0 ? "_L" : "_R";
}

// The translation of three channels, tx to +x on the left side and to -x on the right.
inline Vec translation(const std::vector<int>& channels, const float* c, int side) {
  return {(side < 0 ? -1.0f : 1.0f) * c[channels[0]], c[channels[1]], c[channels[2]]};
}

}  // namespace rigs::production
