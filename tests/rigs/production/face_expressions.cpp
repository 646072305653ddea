#include "production/face_expressions.h"

#include <stdexcept>

namespace rigs::production {
namespace {

constexpr std::size_t most_settings = 16;

// A control and its value as a share of its range; "*" stands for both sides.
struct Setting {
  const char* control;
  float share;
};
struct Expression {
  const char* name;
  Setting settings[most_settings];
};

constexpr Expression expressions[] = {
    {"rest", {}},
    {"AA",
     {{"jaw.rx", 0.55f},
      {"lower_lip_down*", 0.3f},
      {"upper_lip_up*", 0.2f},
      {"lower_lip_mid.ty", -0.2f},
      {"upper_lip1*.ty", 0.15f},
      {"tongue1.rx", 0.2f},
      {"nasolabial4*.ty", -0.2f},
      {"cheek5*.tx", -0.2f}}},
    {"EE",
     {{"jaw.rx", 0.15f},
      {"stretch*", 0.6f},
      {"smile*", 0.2f},
      {"lower_lip_down*", 0.4f},
      {"lip_corner*.tx", 0.3f},
      {"lower_lip1*.ty", -0.3f},
      {"tongue2.rx", -0.3f},
      {"cheek4*.tx", 0.2f}}},
    {"OO",
     {{"jaw.rx", 0.12f},
      {"pucker", 0.75f},
      {"funnel", 0.3f},
      {"lip_corner*.tx", -0.4f},
      {"upper_lip_mid.tz", 0.3f},
      {"lower_lip_mid.tz", 0.35f},
      {"upper_lip2*.roll", 0.3f},
      {"cheek4*.tx", -0.3f}}},
    {"OH",
     {{"jaw.rx", 0.4f},
      {"funnel", 0.6f},
      {"pucker", 0.3f},
      {"upper_lip1*.ty", 0.25f},
      {"lower_lip2*.ty", -0.25f},
      {"lip_corner*.tz", 0.3f},
      {"tongue1.rx", 0.25f}}},
    {"MM",
     {{"press", 0.7f},
      {"upper_lip_roll", 0.4f},
      {"lower_lip_roll", 0.5f},
      {"jaw.rx", 0.03f},
      {"lip_corner*.ty", 0.1f},
      {"upper_lip2*.ty", -0.15f},
      {"zip*", 0.3f},
      {"chin.ty", 0.3f}}},
    {"FV",
     {{"jaw.rx", 0.1f},
      {"lower_lip_roll", 0.7f},
      {"upper_lip_up*", 0.4f},
      {"lower_lip_mid.tz", -0.3f},
      {"lower_lip1*.ty", 0.3f},
      {"upper_lip_mid.ty", 0.2f},
      {"jaw.tz", -0.3f}}},
    {"TH",
     {{"jaw.rx", 0.2f},
      {"tongue.tz", 0.6f},
      {"tongue2.rx", -0.2f},
      {"tongue4.rx", 0.3f},
      {"lower_lip_down*", 0.3f},
      {"stretch*", 0.2f},
      {"upper_lip1*.tz", 0.2f}}},
    {"smile",
     {{"smile*", 0.85f},
      {"cheek_raise*", 0.6f},
      {"squint*", 0.4f},
      {"cheek2*.ty", 0.3f},
      {"nasolabial2*.tz", 0.3f},
      {"lip_corner*.tx", 0.3f},
      {"upper_lip3*.ty", 0.2f},
      {"lower_lid3*.ty", 0.3f},
      {"brow_outer*", 0.2f},
      {"nostril*.tx", 0.3f}}},
    {"laugh",
     {{"smile*", 0.9f},
      {"jaw.rx", 0.5f},
      {"cheek_raise*", 0.9f},
      {"squint*", 0.8f},
      {"sneer*", 0.3f},
      {"upper_lip_up*", 0.5f},
      {"cheek1*.ty", 0.4f},
      {"lower_lid2*.ty", 0.4f},
      {"neck1.rx", -0.3f},
      {"stretch*", 0.4f},
      {"nasolabial1*.tx", 0.3f},
      {"tongue1.rx", 0.3f},
      {"chin.ty", -0.2f}}},
    {"anger",
     {{"brow_squeeze*", 0.9f},
      {"brow_raise*", -0.7f},
      {"sneer*", 0.5f},
      {"wide*", 0.4f},
      {"press", 0.5f},
      {"brow1*.ty", -0.4f},
      {"brow2*.tx", -0.3f},
      {"jaw.tz", 0.5f},
      {"nostril*.tx", 0.6f},
      {"frown*", 0.4f},
      {"upper_lid2*.ty", -0.3f},
      {"glabella.ty", -0.4f},
      {"forehead1*.ty", -0.3f},
      {"throat.tz", 0.4f}}},
    {"sad",
     {{"brow_squeeze*", 0.5f},
      {"brow1*.ty", 0.7f},
      {"brow2*.ty", 0.4f},
      {"brow_outer*", -0.5f},
      {"frown*", 0.7f},
      {"lower_lip_mid.tz", 0.4f},
      {"chin.ty", 0.5f},
      {"upper_lid4*.ty", -0.4f},
      {"lid_twist*", -0.6f},
      {"lower_lip1*.roll", -0.3f},
      {"cheek4*.ty", -0.3f},
      {"blink*", 0.2f}}},
    {"surprise",
     {{"brow_raise*", 0.95f},
      {"wide*", 0.9f},
      {"jaw.rx", 0.6f},
      {"brow3*.ty", 0.4f},
      {"brow4*.ty", 0.4f},
      {"forehead1*.ty", 0.4f},
      {"forehead2*.ty", 0.3f},
      {"upper_lid3*.ty", 0.3f},
      {"funnel", 0.2f},
      {"lip_corner*.ty", -0.3f},
      {"neck1.rx", 0.2f},
      {"throat.ty", -0.3f}}},
    {"disgust",
     {{"sneer*", 0.95f},
      {"upper_lip_up*", 0.7f},
      {"squint*", 0.6f},
      {"brow_squeeze*", 0.6f},
      {"nasolabial1*.ty", 0.5f},
      {"nostril*.ty", 0.5f},
      {"frown*", 0.3f},
      {"tongue.tz", 0.3f},
      {"lower_lip_roll", -0.5f},
      {"nose_tip.ty", 0.4f},
      {"cheek1*.ty", 0.4f},
      {"jaw.rx", 0.2f}}},
    {"smirk",
     {{"smile_L", 0.9f},
      {"cheek_raise_L", 0.5f},
      {"brow_raise_R", 0.7f},
      {"squint_L", 0.5f},
      {"mouth.tx", 0.5f},
      {"mouth.rz", 0.3f},
      {"lip_corner_L.ty", 0.4f},
      {"press", 0.3f},
      {"brow_outer_R", 0.5f},
      {"nasolabial3_L.tx", 0.4f},
      {"jaw.ry", 0.3f}}},
    {"chew",
     {{"jaw.rx", 0.3f},
      {"jaw.ry", 0.7f},
      {"jaw.tx", 0.5f},
      {"zip*", 0.4f},
      {"cheek_puff_L", 0.6f},
      {"mouth.tx", 0.3f},
      {"tongue1.ry", 0.6f},
      {"tongue3.ry", 0.5f},
      {"press", 0.3f},
      {"jawline_L.tx", 0.4f}}},
    {"puff",
     {{"cheek_puff*", 0.9f},
      {"press", 0.6f},
      {"pucker", 0.3f},
      {"zip*", 0.5f},
      {"cheek4*.tz", 0.3f},
      {"nasolabial3*.tz", 0.4f},
      {"wide*", 0.3f},
      {"brow_raise*", 0.3f}}},
    {"blink", {{"blink*", 1}, {"squint*", 0.2f}, {"brow_raise*", -0.1f}, {"lower_lid3*.ty", 0.2f}}},
    {"look_left", {{"look.tx", 0.8f}, {"neck1.ry", 0.4f}, {"neck2.ry", 0.3f}, {"brow_raise_L", 0.2f}}},
    {"look_up", {{"look.ty", 0.8f}, {"neck1.rx", -0.4f}, {"brow_raise*", 0.5f}, {"wide*", 0.3f}}},
    {"look_down", {{"look.ty", -0.8f}, {"look.tx", -0.4f}, {"neck1.rx", 0.5f}, {"neck2.rx", 0.3f}}},
};

// Of all shares: shots stay well within the ranges.
constexpr float strength = 0.7f;

const Expression& find_expression(const std::string& name) {
  for (const Expression& expression : expressions)
    if (name == expression.name) return expression;
  throw std::out_of_range("there is no expression " + name);
}

}  // namespace

std::vector<float> expression(const std::string& name, const ControlList& controls) {
  std::vector<float> pose(controls.list().size());
  for (const Setting& setting : find_expression(name).settings) {
    if (!setting.control) break;
    const std::string text = setting.control;
    const std::size_t star = text.find('*');
    for (const int side : {1, -1}) {
      std::string control = text;
      if (star != std::string::npos) control.replace(star, 1, side_name(side));
      const auto c = static_cast<std::size_t>(controls.index(control));
      const ControlRange& range = controls.list()[c];
      pose[c] = strength * std::abs(setting.share) * (setting.share < 0 ? range.minimum : range.maximum);
    }
  }
  return pose;
}

}  // namespace rigs::production
