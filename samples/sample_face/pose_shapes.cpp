// The animator's expressions as tables of strokes. Strokes of sided shapes are for the left; the right mirrors them.
#include "shape_terms.h"

namespace sample_face {
namespace {

struct PoseShape {
  const char* name;
  const char* group;
  bool sided;
  std::vector<Stroke> positive;
  std::vector<Stroke> negative = {};  // if any, the control is two-sided
  std::vector<Stroke> halfway = {};   // added at half strength: the path's bow
};

constexpr On kUp = On::upper, kLow = On::lower, kFace = On::face, kAll = On::all;

std::vector<PoseShape> brow_shapes() {
  return {
      {"brow_inner",
       "brows",
       true,
       {{{1.5f, 2.8f, 8.2f}, {2.3f, 2.3f, 3}, {-0.05f, 1.0f, -0.1f}},
        {{1.3f, 5.0f, 8.0f}, {2.4f, 1.6f, 3}, {0, 0.35f, 0}, kAll, 0.10f}},
       {{{1.4f, 2.6f, 8.2f}, {2.2f, 2.0f, 3}, {-0.25f, -0.75f, 0.22f}},
        {{0.7f, 1.9f, 8.4f}, {0.9f, 1.3f, 2}, {0, -0.1f, 0}, kAll, 0.14f}},
       {{{1.5f, 2.8f, 8.2f}, {2.2f, 2.0f, 3}, {0, 0.1f, 0.16f}}}},
      {"brow_mid",
       "brows",
       true,
       {{{3.3f, 2.9f, 7.6f}, {2.4f, 2.2f, 3}, {0, 0.95f, -0.1f}},
        {{3.2f, 5.2f, 7.2f}, {2.4f, 1.5f, 3}, {0, 0.3f, 0}, kAll, 0.08f}},
       {{{3.3f, 2.7f, 7.6f}, {2.3f, 1.9f, 3}, {-0.1f, -0.7f, 0.16f}}},
       {{{3.3f, 2.9f, 7.6f}, {2.3f, 2.0f, 3}, {0, 0.08f, 0.15f}}}},
      {"brow_outer",
       "brows",
       true,
       {{{5.0f, 2.6f, 6.2f}, {2.3f, 2.3f, 3}, {0.15f, 1.0f, -0.25f}},
        {{5.2f, 4.8f, 5.8f}, {2.0f, 1.6f, 3}, {0, 0.35f, -0.1f}}},
       {{{5.0f, 2.5f, 6.2f}, {2.2f, 2.0f, 3}, {-0.05f, -0.7f, 0.1f}}},
       {{{5.0f, 2.6f, 6.2f}, {2.2f, 2.0f, 3}, {0.1f, 0, 0.14f}}}},
      {"brow_squeeze",
       "brows",
       true,
       {{{1.6f, 2.5f, 8.2f}, {2.0f, 1.7f, 3}, {-0.5f, -0.3f, 0.12f}},
        {{0.55f, 2.4f, 8.6f}, {0.7f, 1.6f, 2}, {0, 0, 0}, kAll, 0.2f}},
       {},
       {{{1.6f, 2.5f, 8.2f}, {1.8f, 1.5f, 3}, {0.1f, -0.12f, 0.1f}}}},
      {"forehead_fold",
       "brows",
       true,
       {{{2.4f, 4.4f, 7.6f}, {3, 0.7f, 3}, {0, 0, 0}, kAll, 0.14f},
        {{2.4f, 5.4f, 7.2f}, {3, 0.6f, 3}, {0, 0, 0}, kAll, -0.08f},
        {{2.4f, 6.3f, 6.9f}, {3, 0.7f, 3}, {0, 0, 0}, kAll, 0.12f}}},
      {"squint",
       "lids",
       true,
       {{{3.5f, -2.4f, 7.4f}, {2.3f, 1.2f, 2.5f}, {-0.05f, 0.5f, 0.08f}, kAll, 0.12f},
        {{5.4f, 0.0f, 5.8f}, {1.1f, 1.6f, 2}, {-0.25f, 0, 0}, kAll, 0.08f},
        {{3.6f, 2.4f, 7.5f}, {2.4f, 1.2f, 2}, {0, -0.22f, 0.1f}}}},
  };
}

std::vector<PoseShape> cheek_and_nose_shapes() {
  return {
      {"cheek_raise",
       "cheeks",
       true,
       {{{4.0f, -2.9f, 6.9f}, {2.7f, 2.2f, 3}, {0.1f, 0.7f, 0.12f}, kFace, 0.32f},
        {{5.6f, -0.6f, 5.4f}, {1.5f, 1.6f, 2}, {0, 0.2f, 0}, kAll, 0.1f}},
       {},
       {{{4.0f, -3.2f, 6.9f}, {2.4f, 1.9f, 3}, {0.1f, 0, 0.1f}}}},
      {"cheek_puff",
       "cheeks",
       true,
       {{{4.7f, -6.4f, 5.8f}, {2.9f, 2.9f, 3.6f}, {0.25f, 0.05f, 0.1f}, kFace, 0.95f},
        {{2.7f, -7.0f, 7.8f}, {1.4f, 1.6f, 2}, {0, 0, 0.15f}}},
       {{{4.6f, -6.3f, 5.8f}, {2.5f, 2.7f, 3}, {-0.1f, 0, 0}, kFace, -0.75f}},
       {{{4.6f, -6.4f, 5.9f}, {2.4f, 2.4f, 3}, {0, 0.15f, 0}, kFace, 0.15f}}},
      {"nasolabial",
       "cheeks",
       true,
       {{{2.6f, -4.7f, 8.0f}, {0.9f, 1.6f, 2}, {0.05f, 0, 0}, kFace, -0.22f},
        {{3.5f, -4.6f, 7.3f}, {1.2f, 1.8f, 2}, {-0.1f, 0.1f, 0}, kFace, 0.24f}}},
      {"nose_wrinkle",
       "nose",
       true,
       {{{1.15f, -3.7f, 9.0f}, {1.4f, 1.4f, 2}, {0.1f, 0.5f, -0.05f}},
        {{1.1f, 0.3f, 7.9f}, {1.1f, 1.5f, 1.6f}, {0, -0.12f, 0}, kAll, 0.17f},
        {{2.3f, -3.2f, 8.0f}, {1.4f, 1.6f, 2}, {0, 0.45f, 0.1f}, kFace, 0.10f}},
       {},
       {{{1.2f, -3.6f, 9.0f}, {1.2f, 1.2f, 2}, {0.12f, 0, 0}}}},
      {"nostril",
       "nose",
       true,
       {{{1.45f, -4.1f, 8.9f}, {1.1f, 1.0f, 1.5f}, {0.36f, 0.12f, 0.02f}}},
       {{{1.4f, -4.1f, 8.9f}, {1.1f, 1.0f, 1.5f}, {-0.3f, -0.05f, 0.05f}}}},
      {"nose_tip",
       "nose",
       false,
       {{{0, -3.7f, 10.2f}, {1.6f, 1.4f, 2}, {0, 0.42f, 0.05f}}},
       {{{0, -3.7f, 10.2f}, {1.6f, 1.6f, 2}, {0, -0.45f, -0.08f}}}},
      {"nose_side",
       "nose",
       false,
       {{{0, -3.8f, 9.8f}, {2.2f, 2.2f, 3}, {0.42f, 0.05f, 0}}},
       {{{0, -3.8f, 9.8f}, {2.2f, 2.2f, 3}, {-0.42f, 0.05f, 0}}}},
      {"ear_back", "cheeks", true, {{{8.3f, -1.0f, -1.6f}, {2.2f, 4.0f, 3.0f}, {-0.35f, 0.12f, -0.3f}}}},
  };
}

std::vector<PoseShape> mouth_side_shapes() {
  return {
      {"smile",
       "mouth",
       true,
       {{{2.7f, -7.0f, 8.1f}, {2.2f, 1.9f, 3}, {1.2f, 1.3f, -0.7f}},
        {{1.1f, -7.0f, 9.0f}, {1.9f, 1.5f, 2.5f}, {0.3f, 0.12f, -0.22f}},
        {{0, -7.3f, 9.1f}, {2.0f, 1.4f, 2}, {0, -0.12f, 0}},
        {{4.1f, -3.9f, 6.9f}, {2.3f, 2.1f, 2.6f}, {0.15f, 0.5f, 0.1f}, kFace, 0.40f},
        {{2.75f, -5.1f, 8.0f}, {0.9f, 1.5f, 2}, {0.25f, 0.25f, 0}, kFace, -0.16f},
        {{4.6f, -7.6f, 5.9f}, {1.8f, 2.2f, 3}, {0.25f, 0.4f, -0.15f}, kFace}},
       {},
       {{{2.7f, -7.0f, 8.1f}, {2.0f, 1.7f, 3}, {0.22f, -0.16f, 0.10f}},
        {{4.0f, -4.4f, 7.0f}, {2.0f, 1.9f, 2.5f}, {0, 0, 0}, kFace, 0.1f}}},
      {"frown",
       "mouth",
       true,
       {{{2.7f, -7.1f, 8.1f}, {1.9f, 1.7f, 3}, {0.15f, -0.95f, -0.12f}},
        {{3.3f, -8.7f, 7.2f}, {1.6f, 1.5f, 2.5f}, {0.1f, -0.3f, 0}, kFace, 0.14f}},
       {},
       {{{2.7f, -7.1f, 8.1f}, {1.8f, 1.6f, 3}, {-0.15f, 0.05f, 0.1f}}}},
      {"mouth_wide",
       "mouth",
       true,
       {{{2.7f, -7.1f, 8.1f}, {2.3f, 1.9f, 3}, {0.85f, 0, -0.5f}},
        {{1.2f, -7.1f, 9.0f}, {1.9f, 1.6f, 2}, {0.25f, 0, -0.18f}}},
       {{{2.6f, -7.1f, 8.1f}, {2.4f, 1.9f, 3}, {-0.85f, 0, 0.4f}},
        {{1.0f, -7.1f, 9.0f}, {1.7f, 1.6f, 2}, {-0.25f, 0, 0.22f}}},
       {{{2.7f, -7.1f, 8.1f}, {2, 1.8f, 3}, {0.1f, 0, 0.14f}}}},
      {"upper_lip_raise",
       "mouth",
       true,
       {{{1.2f, -6.5f, 9.0f}, {1.8f, 1.7f, 2.5f}, {0.1f, 0.75f, 0.04f}, kUp},
        {{2.3f, -5.2f, 8.1f}, {1.5f, 1.3f, 2}, {0.05f, 0.35f, 0}, kFace, 0.13f}},
       {},
       {{{1.2f, -6.5f, 9.0f}, {1.6f, 1.5f, 2.5f}, {0, -0.08f, 0.12f}, kUp}}},
      {"lower_lip_down",
       "mouth",
       true,
       {{{1.2f, -7.8f, 8.9f}, {1.9f, 1.7f, 2.5f}, {0.15f, -0.8f, -0.04f}, kLow},
        {{1.3f, -9.2f, 8.3f}, {1.6f, 1.2f, 2}, {0, -0.2f, 0}, kLow, 0.1f}},
       {},
       {{{1.2f, -7.8f, 8.9f}, {1.7f, 1.5f, 2.5f}, {0, 0.06f, 0.14f}, kLow}}},
      {"dimple",
       "mouth",
       true,
       {{{2.9f, -7.0f, 8.0f}, {1.5f, 1.3f, 2}, {0.4f, 0.05f, -0.5f}},
        {{3.7f, -6.9f, 7.2f}, {0.9f, 1.3f, 2}, {0, 0, 0}, kFace, 0.18f}}},
      {"stretch",
       "mouth",
       true,
       {{{2.8f, -7.4f, 8.0f}, {2.2f, 2.0f, 3}, {0.75f, -0.55f, -0.4f}},
        {{3.6f, -9.4f, 6.6f}, {2.0f, 1.8f, 3}, {0.2f, -0.35f, 0}}},
       {},
       {{{2.8f, -7.4f, 8.0f}, {2.0f, 1.8f, 3}, {0.1f, 0.1f, 0.1f}}}},
      {"lip_press",
       "mouth",
       true,
       {{{1.4f, -6.65f, 9.0f}, {1.7f, 0.9f, 2}, {0, -0.18f, -0.2f}, kUp},
        {{1.4f, -7.7f, 9.0f}, {1.7f, 1.0f, 2}, {0, 0.22f, -0.2f}, kLow},
        {{1.5f, -5.7f, 8.7f}, {1.6f, 0.8f, 2}, {0, 0, 0}, kFace, 0.12f}}},
      {"lip_tighten",
       "mouth",
       true,
       {{{2.0f, -7.1f, 8.7f}, {1.9f, 1.5f, 2}, {-0.3f, 0, -0.1f}},
        {{1.3f, -6.6f, 9.0f}, {1.5f, 0.8f, 2}, {0, -0.15f, 0}, kUp, -0.08f},
        {{1.3f, -7.7f, 9.0f}, {1.5f, 0.9f, 2}, {0, 0.15f, 0}, kLow, -0.08f}}},
      {"sneer",
       "mouth",
       true,
       {{{1.7f, -6.0f, 8.6f}, {1.7f, 1.6f, 2.5f}, {0.2f, 0.65f, 0.05f}, kUp},
        {{1.4f, -4.2f, 8.8f}, {1.1f, 1.1f, 2}, {0.15f, 0.3f, 0}},
        {{2.4f, -4.6f, 8.0f}, {0.9f, 1.3f, 2}, {0, 0.1f, 0}, kFace, -0.12f}}},
      {"corner_in",
       "mouth",
       true,
       {{{2.7f, -7.1f, 8.1f}, {1.4f, 1.2f, 2}, {-0.35f, 0, 0.2f}}},
       {{{2.7f, -7.1f, 8.1f}, {1.5f, 1.3f, 2}, {0.2f, 0, -0.25f}}}},
      {"jaw_clench",
       "jaw",
       true,
       {{{6.0f, -7.2f, 1.9f}, {2.0f, 2.4f, 2.6f}, {0.1f, 0, 0}, kFace, 0.30f},
        {{5.9f, 0.8f, 4.2f}, {1.5f, 1.8f, 2}, {0, 0, 0}, kAll, 0.10f}}},
      {"neck_tense",
       "neck",
       true,
       {{{2.7f, -13.8f, 0.7f}, {1.5f, 3.4f, 2.5f}, {0.25f, 0, 0}, kAll, 0.28f},
        {{3.2f, -10.9f, 5.2f}, {2.4f, 1.4f, 2.5f}, {0.2f, -0.35f, 0}, kFace}}},
      {"neck_turn",
       "neck",
       true,
       {{{1.9f, -14.4f, 1.1f}, {1.1f, 3.2f, 2.4f}, {0, 0, 0}, kAll, 0.34f},
        {{0.9f, -16.4f, 1.1f}, {1.0f, 1.4f, 2}, {0, 0, 0}, kAll, 0.2f}}},
  };
}

std::vector<PoseShape> mouth_middle_shapes() {
  const Vec3 corner{2.6f, -7.1f, 8.2f};
  return {
      {"pucker",
       "mouth",
       false,
       {{{0, -7.1f, 8.7f}, {6.5f, 3.2f, 5.0f}, {0, 0, 0.6f}, kAll, 0, {-0.55f, 0.06f, 0}},
        {corner, {1.7f, 1.8f, 3}, {-0.45f, 0, 0.3f}},
        {mirrored(corner), {1.7f, 1.8f, 3}, {0.45f, 0, 0.3f}},
        {{0, -7.1f, 9.1f}, {2.8f, 1.9f, 2.5f}, {0, 0, 0.6f}, kAll, 0, {0, 0.14f, 0}},
        {{0, -6.2f, 9.0f}, {2.6f, 1.0f, 2.2f}, {0, 0.10f, 0.12f}, kUp},
        {{0, -8.1f, 9.0f}, {2.6f, 1.0f, 2.2f}, {0, -0.10f, 0.12f}, kLow},
        {{4.4f, -6.4f, 6.6f}, {1.8f, 2.2f, 2.5f}, {0, 0, 0}, kFace, -0.2f},
        {{-4.4f, -6.4f, 6.6f}, {1.8f, 2.2f, 2.5f}, {0, 0, 0}, kFace, -0.2f}},
       {},
       {{corner, {2.2f, 1.8f, 3}, {0.08f, 0, 0.22f}}, {mirrored(corner), {2.2f, 1.8f, 3}, {-0.08f, 0, 0.22f}}}},
      {"funnel",
       "mouth",
       false,
       {{{0, -7.1f, 8.7f}, {5.0f, 2.9f, 4.5f}, {0, 0, 0.4f}, kAll, 0, {-0.42f, 0.05f, 0}},
        {corner, {2.0f, 1.8f, 3}, {-0.3f, 0, 0.2f}},
        {mirrored(corner), {2.0f, 1.8f, 3}, {0.3f, 0, 0.2f}},
        {{0, -6.4f, 9.1f}, {2.6f, 1.4f, 2.5f}, {0, 0.5f, 0.3f}, kUp},
        {{0, -7.9f, 9.0f}, {2.6f, 1.5f, 2.5f}, {0, -0.6f, 0.3f}, kLow}},
       {},
       {{{0, -7.1f, 9.0f}, {2.4f, 1.7f, 2.5f}, {0, 0, 0.2f}}}},
      {"chin_raise",
       "mouth",
       false,
       {{{0, -9.8f, 8.1f}, {2.2f, 1.7f, 3}, {0, 0.55f, 0.1f}, kLow, 0.12f},
        {{0, -7.9f, 8.9f}, {2.2f, 1.2f, 2.5f}, {0, 0.5f, 0.2f}, kLow},
        {{0, -6.6f, 9.0f}, {2.0f, 0.9f, 2}, {0, 0.3f, 0.08f}, kUp}}},
      {"upper_lip_push",
       "mouth",
       false,
       {{{0, -6.6f, 9.1f}, {2.2f, 1.2f, 2}, {0, 0, 0.42f}, kUp}},
       {{{0, -6.6f, 9.1f}, {2.2f, 1.2f, 2}, {0, 0, -0.3f}, kUp}}},
      {"lower_lip_push",
       "mouth",
       false,
       {{{0, -7.8f, 9.1f}, {2.2f, 1.2f, 2}, {0, 0.05f, 0.5f}, kLow}},
       {{{0, -7.8f, 9.1f}, {2.2f, 1.2f, 2}, {0, 0.1f, -0.35f}, kLow}}},
      {"mouth_height",
       "mouth",
       false,
       {{{0, -7.1f, 8.6f}, {4.0f, 2.6f, 4}, {0, 0.6f, 0}}},
       {{{0, -7.1f, 8.6f}, {4.0f, 2.6f, 4}, {0, -0.6f, -0.05f}}}},
      {"lips_suck",
       "mouth",
       false,
       {{{0, -6.7f, 9.1f}, {2.6f, 1.1f, 2}, {0, -0.25f, -0.45f}, kUp},
        {{0, -7.7f, 9.1f}, {2.6f, 1.2f, 2}, {0, 0.28f, -0.45f}, kLow}}},
      {"lip_bite",
       "mouth",
       false,
       {{{0, -7.6f, 9.0f}, {2.0f, 1.2f, 2}, {0, 0.32f, -0.55f}, kLow},
        {{0, -6.6f, 9.0f}, {2.0f, 0.9f, 2}, {0, 0.14f, 0.05f}, kUp}},
       {},
       {{{0, -7.6f, 9.0f}, {2.0f, 1.2f, 2}, {0, -0.2f, 0.1f}, kLow}}},
      {"chin_side",
       "jaw",
       false,
       {{{0, -10.0f, 7.6f}, {2.4f, 1.8f, 3}, {0.45f, 0, 0}, kLow}},
       {{{0, -10.0f, 7.6f}, {2.4f, 1.8f, 3}, {-0.45f, 0, 0}, kLow}}},
      {"throat_puff",
       "neck",
       false,
       {{{0, -12.0f, 3.2f}, {3.2f, 2.4f, 3.5f}, {0, -0.2f, 0}, kFace, 0.6f}},
       {{{0, -12.0f, 3.2f}, {3.0f, 2.4f, 3.5f}, {0, 0.1f, 0}, kFace, -0.35f}}},
      {"swallow",
       "neck",
       false,
       {{{0, -13.6f, 1.7f}, {1.5f, 1.7f, 2}, {0, 0.5f, 0}, kAll, 0.30f}},
       {},
       {{{0, -13.4f, 1.7f}, {1.5f, 1.7f, 2}, {0, 0, 0}, kAll, 0.2f}}},
  };
}

std::vector<Stroke> throat_strokes() {
  return {{{0, -12.2f, 3.0f}, {4.2f, 3.0f, 3.8f}, {0, -0.6f, 0.9f}}};
}

std::vector<Stroke> mirrored(std::vector<Stroke> strokes) {
  for (Stroke& s : strokes) s = sample_face::mirrored(s);
  return strokes;
}

}  // namespace

void add_pose_shapes(const Canvas& canvas, Controls& controls, std::vector<Term>& terms) {
  // The throat gives way to the opening jaw.
  terms.push_back({Law::side, {{{controls.index("jaw_open"), 1}}}, 1, paint(canvas, throat_strokes())});
  const auto add = [&](const PoseShape& shape, const std::string& suffix, bool mirror) {
    const int control = controls.add(shape.name + suffix, shape.group, !shape.negative.empty());
    const auto draw = [&](Law law, float sign, const std::vector<Stroke>& strokes) {
      if (strokes.empty()) return;
      terms.push_back({law, {{{control, sign}}}, 1, paint(canvas, mirror ? mirrored(strokes) : strokes)});
    };
    draw(Law::side, 1, shape.positive);
    draw(Law::side, -1, shape.negative);
    draw(Law::between, 1, shape.halfway);
  };
  for (const auto& table : {brow_shapes(), cheek_and_nose_shapes(), mouth_side_shapes(), mouth_middle_shapes()})
    for (const PoseShape& shape : table) {
      add(shape, shape.sided ? "_L" : "", false);
      if (shape.sided) add(shape, "_R", true);
    }
}

}  // namespace sample_face
