#include "face_labels.h"

#include <algorithm>
#include <string_view>

namespace sample_face {
namespace {

struct Meaning {
  const char* control;  // of a sided one without "_L" and "_R"
  const char* arkit;    // likewise without "Left" and "Right"; null: none
  const char* facs;     // with "L" and "R" of sided ones; null: none
};

// The numbers are those of Ekman, Friesen and Hager, "Facial Action Coding System", 2002.
constexpr Meaning kSided[] = {
    {"brow_inner", nullptr, "AU1"},  // browInnerUp is both sides at once
    {"brow_outer", "browOuterUp", "AU2"},
    {"brow_squeeze", "browDown", "AU4"},
    {"upper_lid", "eyeWide", "AU5"},
    {"cheek_raise", "cheekSquint", "AU6"},
    {"squint", "eyeSquint", "AU7"},
    {"nose_wrinkle", "noseSneer", "AU9"},
    {"upper_lip_raise", "mouthUpperUp", "AU10"},
    {"nasolabial", nullptr, "AU11"},
    {"smile", "mouthSmile", "AU12"},
    {"dimple", "mouthDimple", "AU14"},
    {"frown", "mouthFrown", "AU15"},
    {"lower_lip_down", "mouthLowerDown", "AU16"},
    {"stretch", "mouthStretch", "AU20"},
    {"neck_tense", nullptr, "AU21"},
    {"lip_tighten", nullptr, "AU23"},
    {"lip_press", "mouthPress", "AU24"},
    {"jaw_clench", nullptr, "AU31"},
    {"cheek_puff", nullptr, "AU34"},  // cheekPuff is both sides at once
    {"nostril", nullptr, "AU38"},
    {"blink", "eyeBlink", "AU45"},
};
constexpr Meaning kWhole[] = {
    {"chin_raise", "mouthShrugLower", "AU17"},
    {"pucker", "mouthPucker", "AU18"},
    {"tongue_out", "tongueOut", "AU19"},
    {"funnel", "mouthFunnel", "AU22"},
    {"jaw_open", "jawOpen", "AU26"},
    {"lips_suck", nullptr, "AU28"},
    {"jaw_forward", "jawForward", "AU29"},
    {"jaw_side", nullptr, "AU30"},
    {"lip_bite", nullptr, "AU32"},
    {"swallow", nullptr, "AU80"},
    {"lips_together", "mouthClose", nullptr},
    {"upper_lip_push", "mouthShrugUpper", nullptr},
};

// Points of the lips go along x on both sides, and so do the eyes: towards the nose on one, away from it on the other.
bool goes_across(const std::string& name) {
  return name.starts_with("eye_yaw") || (name.starts_with("lip_") && name.ends_with("_x"));
}

// The name on the other side: "smile_L" and "smile_R", "lip_upper_L3_full" and "lip_upper_R3_full"; else "".
std::string other_side(std::string name) {
  for (std::size_t i = 1; i < name.size(); ++i) {
    const bool alone = i + 1 == name.size() || (name[i + 1] >= '0' && name[i + 1] <= '9');
    if (name[i - 1] != '_' || !alone || (name[i] != 'L' && name[i] != 'R')) continue;
    name[i] = name[i] == 'L' ? 'R' : 'L';
    return name;
  }
  return "";
}

std::string text(const char* name, const char* suffix) {
  return name ? std::string(name) + suffix : "";
}

}  // namespace

std::vector<ControlLabels> label(const Controls& controls) {
  std::vector<ControlLabels> labels(controls.list().size());
  const auto set = [&](const Meaning& meaning, const char* suffix, const char* arkit, const char* facs) {
    ControlLabels& to = labels[std::size_t(controls.index(std::string(meaning.control) + suffix))];
    to.arkit = text(meaning.arkit, arkit);
    to.facs = text(meaning.facs, facs);
  };
  for (const Meaning& meaning : kSided) {
    set(meaning, "_L", "Left", "L");
    set(meaning, "_R", "Right", "R");
  }
  for (const Meaning& meaning : kWhole) set(meaning, "", "", "");
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (const std::string& name = controls.list()[i].name; !goes_across(name)) labels[i].mirror = other_side(name);
  return labels;
}

}  // namespace sample_face
