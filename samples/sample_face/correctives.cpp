// Correctives: what is added when controls act together. Where two shapes would move the same skin, part of the doubled
// movement is taken back; some pairs fold or bulge the skin between them.
#include "shape_terms.h"

namespace sample_face {
namespace {

// `a` and `b` (and `c`) are controls, "-name" for the negative side; a name ending in "_*" stands for both sides, taken
// together. `keep_back` is how much of the movement common to a and b is taken back (negative: added).
struct Pairing {
  const char* a;
  const char* b;
  float keep_back;
  Law law = Law::product;
  const char* c = nullptr;
};

const Pairing kPairings[] = {
    {"brow_inner_*", "brow_mid_*", 0.68f},
    {"brow_mid_*", "brow_outer_*", 0.68f},
    {"brow_inner_*", "brow_outer_*", 0.54f, Law::minimum},
    {"-brow_inner_*", "-brow_mid_*", 0.68f},
    {"-brow_mid_*", "-brow_outer_*", 0.68f},
    {"-brow_inner_*", "brow_squeeze_*", 0.81f, Law::minimum},
    {"brow_inner_*", "brow_squeeze_*", -0.68f},
    {"-brow_mid_*", "brow_squeeze_*", 0.54f},
    {"brow_inner_*", "forehead_fold_*", -0.81f},
    {"brow_mid_*", "forehead_fold_*", -0.81f},
    {"brow_outer_*", "forehead_fold_*", -0.68f, Law::minimum},
    {"-brow_mid_*", "squint_*", 0.68f},
    {"-brow_outer_*", "squint_*", 0.68f, Law::minimum},
    {"-brow_inner_*", "nose_wrinkle_*", 0.68f, Law::minimum},
    {"brow_squeeze_*", "nose_wrinkle_*", -0.81f},
    {"brow_inner_*", "brow_mid_*", 0.41f, Law::product, "brow_outer_*"},
    {"-brow_inner_*", "brow_squeeze_*", -0.41f, Law::product, "nose_wrinkle_*"},
    {"-brow_inner_*", "-brow_mid_*", 0.41f, Law::minimum, "-brow_outer_*"},
    {"squint_*", "cheek_raise_*", 0.81f, Law::minimum},
    {"squint_*", "smile_*", -0.41f},
    {"cheek_raise_*", "smile_*", 0.45f},
    {"cheek_raise_*", "nose_wrinkle_*", -0.54f},
    {"cheek_raise_*", "upper_lip_raise_*", 0.54f},
    {"cheek_raise_*", "nasolabial_*", -0.81f},
    {"cheek_raise_*", "sneer_*", -0.54f, Law::minimum},
    {"cheek_raise_*", "smile_*", -0.41f, Law::product, "squint_*"},
    {"cheek_puff_*", "smile_*", 0.81f, Law::minimum},
    {"cheek_puff_*", "mouth_wide_*", 0.68f},
    {"cheek_puff_*", "pucker", -0.41f},
    {"-cheek_puff_*", "pucker", 0.81f},
    {"-cheek_puff_*", "jaw_clench_*", 0.54f, Law::minimum},
    {"cheek_puff_*", "jaw_clench_*", 0.54f},
    {"nasolabial_*", "smile_*", -0.94f},
    {"nasolabial_*", "upper_lip_raise_*", -0.68f, Law::minimum},
    {"nasolabial_*", "sneer_*", -0.54f},
    {"nasolabial_*", "nose_wrinkle_*", -0.68f, Law::minimum},
    {"nose_wrinkle_*", "upper_lip_raise_*", 0.54f},
    {"nose_wrinkle_*", "sneer_*", 0.68f, Law::minimum},
    {"nose_wrinkle_*", "nostril_*", -0.68f},
    {"nose_wrinkle_*", "smile_*", 0.54f},
    {"-nostril_*", "nose_wrinkle_*", 0.54f},
    {"smile_*", "mouth_wide_*", 0.55f},
    {"smile_*", "-mouth_wide_*", 0.54f, Law::minimum},
    {"smile_*", "frown_*", -0.68f, Law::minimum},
    {"smile_*", "stretch_*", 0.68f},
    {"smile_*", "dimple_*", -0.68f},
    {"smile_*", "upper_lip_raise_*", 0.45f},
    {"smile_*", "lower_lip_down_*", 0.54f},
    {"smile_*", "lip_press_*", -0.68f, Law::minimum},
    {"smile_*", "lip_tighten_*", 0.68f},
    {"smile_*", "sneer_*", 0.54f},
    {"smile_*", "corner_in_*", 0.68f, Law::minimum},
    {"smile_*", "pucker", 0.45f},
    {"smile_*", "funnel", 0.45f},
    {"smile_*", "chin_raise", 0.41f, Law::minimum},
    {"smile_*", "jaw_open", 0.28f},
    {"smile_*", "mouth_wide_*", 0.41f, Law::product, "jaw_open"},
    {"smile_*", "pucker", 0.41f, Law::product, "jaw_open"},
    {"smile_*", "upper_lip_raise_*", 0.54f, Law::minimum, "lower_lip_down_*"},
    {"frown_*", "stretch_*", 0.68f},
    {"frown_*", "mouth_wide_*", 0.54f},
    {"frown_*", "chin_raise", -0.54f},
    {"frown_*", "pucker", 0.54f, Law::minimum},
    {"frown_*", "jaw_open", 0.25f},
    {"frown_*", "lower_lip_down_*", 0.54f, Law::minimum},
    {"mouth_wide_*", "stretch_*", 0.68f},
    {"mouth_wide_*", "dimple_*", 0.54f, Law::minimum},
    {"mouth_wide_*", "pucker", 0.68f},
    {"mouth_wide_*", "funnel", 0.68f},
    {"mouth_wide_*", "jaw_open", 0.41f},
    {"-mouth_wide_*", "pucker", 0.55f},
    {"-mouth_wide_*", "funnel", 0.68f},
    {"-mouth_wide_*", "jaw_open", 0.25f},
    {"upper_lip_raise_*", "sneer_*", 0.68f, Law::minimum},
    {"upper_lip_raise_*", "funnel", 0.68f},
    {"upper_lip_raise_*", "pucker", 0.54f},
    {"upper_lip_raise_*", "jaw_open", -0.41f},
    {"upper_lip_raise_*", "stretch_*", 0.41f},
    {"lower_lip_down_*", "funnel", 0.68f},
    {"lower_lip_down_*", "pucker", 0.54f},
    {"lower_lip_down_*", "jaw_open", 0.45f},
    {"lower_lip_down_*", "stretch_*", 0.54f, Law::minimum},
    {"lower_lip_down_*", "chin_raise", 0.81f, Law::minimum},
    {"lower_lip_down_*", "lip_bite", 0.68f},
    {"lip_press_*", "lip_tighten_*", 0.68f},
    {"lip_press_*", "pucker", 0.54f},
    {"lip_press_*", "lips_suck", 0.81f, Law::minimum},
    {"lip_tighten_*", "pucker", 0.54f},
    {"lip_tighten_*", "chin_raise", 0.41f},
    {"stretch_*", "jaw_open", 0.35f},
    {"stretch_*", "neck_tense_*", -0.41f},
    {"neck_tense_*", "neck_turn_*", 0.68f},
    {"dimple_*", "stretch_*", 0.54f},
    {"corner_in_*", "pucker", 0.68f},
    {"pucker", "funnel", 0.68f},
    {"pucker", "funnel", 0.41f, Law::product, "jaw_open"},
    {"pucker", "jaw_open", 0.25f},
    {"pucker", "chin_raise", 0.54f},
    {"pucker", "upper_lip_push", 0.54f},
    {"pucker", "lower_lip_push", 0.54f},
    {"funnel", "jaw_open", 0.41f},
    {"funnel", "upper_lip_push", 0.54f, Law::minimum},
    {"funnel", "lower_lip_push", 0.54f, Law::minimum},
    {"chin_raise", "jaw_open", 0.54f, Law::minimum},
    {"chin_raise", "lower_lip_push", 0.54f},
    {"lips_suck", "lip_bite", 0.68f},
    {"lips_suck", "pucker", 0.68f},
    {"funnel", "lips_suck", 0.68f},
    {"mouth_height", "chin_raise", 0.54f},
    {"-mouth_height", "jaw_open", 0.41f},
    {"throat_puff", "swallow", -0.54f},
};

// "smile_*" -> "smile_L".
std::string for_side(const char* name, char side) {
  std::string s(name);
  if (s.back() == '*') s.back() = side;
  return s;
}

// What a driver draws on its own, as a dense list. Motions such as the jaw's draw nothing here.
std::vector<Vec3> own_shape(Driver driver, const std::vector<Term>& terms, std::size_t vertices) {
  std::vector<Vec3> shape(vertices);
  for (const Term& t : terms)
    if (t.law == Law::side && t.drivers[0].control == driver.control && t.drivers[0].sign == driver.sign)
      for (std::size_t i = 0; i < t.delta.vertices.size(); ++i) shape[t.delta.vertices[i]] += t.delta.moves[i];
  return shape;
}

// Movement that a and b share: along their sum, as long as the shorter of the two. A driver without a shape of its own
// shares everything.
Delta shared_movement(const std::vector<Vec3>& a, const std::vector<Vec3>& b, bool b_is_motion, float factor) {
  std::vector<Vec3> shared(a.size());
  for (std::size_t v = 0; v < a.size(); ++v) {
    const float la = length(a[v]), lb = length(b[v]);
    shared[v] = b_is_motion ? a[v] * factor : unit(a[v] + b[v]) * (std::min(la, lb) * factor);
  }
  return sparse(shared);
}

}  // namespace

void add_correctives(const Canvas& canvas, const Controls& controls, std::vector<Term>& terms) {
  const auto driver = [&](const char* name, char side) {
    const float sign = name[0] == '-' ? -1.0f : 1.0f;
    return Driver{controls.index(for_side(sign < 0 ? name + 1 : name, side)), sign};
  };
  const std::vector<Term> shapes = terms;
  for (const Pairing& p : kPairings) {
    const bool sided = std::string(p.a).back() == '*' || std::string(p.b).back() == '*';
    for (const char side : {'L', 'R'}) {
      if (!sided && side == 'R') continue;
      Term term{p.law, {driver(p.a, side), driver(p.b, side)}, 2, {}};
      const auto a = own_shape(term.drivers[0], shapes, canvas.points.size());
      const auto b = own_shape(term.drivers[1], shapes, canvas.points.size());
      const bool motion = std::string(p.b) == "jaw_open";
      term.delta = shared_movement(a, b, motion, -p.keep_back);
      if (p.c) term.drivers[term.driver_count++] = driver(p.c, side);
      terms.push_back(std::move(term));
    }
  }
}

}  // namespace sample_face
