#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fb {

// One number an animator moves.
struct Control {
  std::string name;
  float minimum = 0, maximum = 1;  // minimum < maximum
  float rest = 0;                  // its value in the rest pose ("default"), within the range
  std::string group;               // the region of the face it belongs to, as the rig calls it; may be empty

  // The larger of the two distances from rest to the ends of the range: what one unit of an identity feature is.
  float reach() const;
};

// What a rig is asked with: its controls, in the order of the columns of every pose.
struct RigSchema {
  std::string name;
  std::string units = "cm";
  std::string up_axis = "y";  // "y" or "z"
  std::vector<Control> controls;

  std::size_t control_count() const { return controls.size(); }
  std::optional<std::size_t> find(std::string_view control) const;
  // The control whose name takes the fewest edits to become `misspelt`, for messages; "" if there are no controls.
  std::string_view closest(std::string_view misspelt) const;
  std::vector<float> rest_pose() const;
};

// Fails by name on no controls, an up axis that is none, an empty or duplicate name, a range that is empty or not
// finite, a rest value outside it.
void check(const RigSchema& schema);

// Fails unless both have the same controls in the same order with the same ranges; `a_name`, `b_name` say whose they
// are.
void check_same_controls(const RigSchema& a, const char* a_name, const RigSchema& b, const char* b_name);

}  // namespace fb
