#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fb {

// What a control means, beside its name; each may be empty.
struct ControlLabels {
  std::string arkit;   // its name among the face blendshapes of ARKit: "jawOpen"
  std::string facs;    // its action unit in the Facial Action Coding System: "AU26"
  std::string unit;    // of its values: "degrees"
  std::string mirror;  // the name of the control that does the same on the other side
  bool operator==(const ControlLabels&) const = default;
};

// One scalar input of a rig.
struct Control {
  std::string name;
  float minimum = 0, maximum = 1;  // minimum < maximum
  float rest = 0;                  // value in the rest pose ("default"), within the range
  std::string group;               // its control group, as the rig names it; may be empty
  ControlLabels labels = {};

  // The larger distance from rest to an end of the range: one unit of an identity feature.
  float reach() const;
};

// A named number that a rig gives with each pose, beside positions, such as the weight of a wrinkle map. In memory the
// channels of a face are carried by the last vertices of its mesh, three by each: the coordinate that carries one is
// (value - rest) / scale.
struct Channel {
  std::string name;
  std::string unit;                // of its values: "degrees"; may be empty
  float minimum = 0, maximum = 1;  // minimum < maximum
  float rest = 0;                  // value in the rest pose, within the range
  float scale = 0;                 // above 0; 0 where no vertices carry it yet

  float value(float coordinate) const {  // clamped to the range, as EVALUATION.md says
    const float value = rest + scale * coordinate;
    return value > minimum ? (value < maximum ? value : maximum) : minimum;
  }
  bool operator==(const Channel&) const = default;
};

// The inputs of a rig: its controls, in the order of the columns of every pose; and its outputs beside positions.
struct RigSchema {
  std::string name;
  std::string units = "cm";
  std::string up_axis = "y";  // "y" or "z"
  std::vector<Control> controls;
  std::vector<Channel> channels = {};

  std::size_t control_count() const { return controls.size(); }
  // The control of this name; if there is none, the one of this ARKit name; if there is none, of this FACS name.
  std::optional<std::size_t> find(std::string_view control) const;
  // The control name with the smallest edit distance to `misspelt`, for messages, of as many as can be compared in a
  // few milliseconds; "" if that is none.
  std::string_view closest(std::string_view misspelt) const;
  std::vector<float> rest_pose() const;
};

// Fails, naming the control, on an invalid up axis, an empty list of controls, an empty or duplicate name, a range that
// is empty or not finite, a rest value outside its range, an ARKit or FACS name of two controls, or mirror partners
// that are not each other's; on the same of channels.
void check(const RigSchema& schema);

// Fails unless both have the same controls in the same order with the same ranges. `a_name`, `b_name`: the rigs' names
// in the message.
void check_same_controls(const RigSchema& a, const char* a_name, const RigSchema& b, const char* b_name);

// The same of channels.
void check_same_channels(const RigSchema& a, const char* a_name, const RigSchema& b, const char* b_name);

}  // namespace fb
