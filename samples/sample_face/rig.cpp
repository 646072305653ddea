#include "rig.h"

#include "anatomy.h"
#include "skin_weights.h"

namespace sample_face {
namespace {

// Skin gives less and less the further it is drawn: what all shapes together ask for stays within kReach.
void resist(const FaceMesh& mesh, Vec3* points) {
  constexpr float kReach = 1.7f;  // cm
  for (Index v = 0; v < mesh.skin.count; ++v) {
    const Vec3 asked = points[v] - mesh.points[v];
    points[v] = mesh.points[v] + asked * (1 / std::sqrt(1 + dot(asked, asked) / (kReach * kReach)));
  }
}

}  // namespace

Rig::Rig()
    : mesh_(build_face_mesh()),
      jaw_weight_(jaw_weights(mesh_)),
      motion_(add_motion_controls(controls_)),
      jaw_(mesh_, jaw_weight_),
      lips_(mesh_),
      lids_{Lids(mesh_, 0), Lids(mesh_, 1)},
      eyes_(mesh_),
      tongue_(mesh_),
      bend_(mesh_) {
  const Canvas canvas = make_canvas(mesh_, jaw_weight_);
  add_pose_shapes(canvas, controls_, terms_);
  add_tweakers(canvas, controls_, terms_);
  add_correctives(canvas, controls_, terms_);
  const char* const sides[2] = {"_L", "_R"};
  for (int side = 0; side < 2; ++side) {
    smile_[side] = controls_.index(std::string("smile") + sides[side]);
    cheek_raise_[side] = controls_.index(std::string("cheek_raise") + sides[side]);
    squint_[side] = controls_.index(std::string("squint") + sides[side]);
  }
  rest_.resize(mesh_.points.size());
  pose(std::vector<float>(controls_.list().size(), 0.0f).data(), rest_.data());
}

void Rig::pose(const float* c, Vec3* points) const {
  std::copy(mesh_.points.begin(), mesh_.points.end(), points);
  for (const Term& term : terms_)
    if (const float w = term.weight(c); w != 0) term.delta.apply(w, points);
  resist(mesh_, points);
  const Motion jaw = Jaw::motion(motion_, c);
  const std::array<Motion, 2> eyes = {Eyes::motion(motion_, c, 0), Eyes::motion(motion_, c, 1)};
  lips_.roll(motion_, c, points);
  tongue_.pose(motion_, c, points);
  jaw_.pose(jaw, points);
  lips_.swing(motion_, c, points);
  lips_.touch(motion_, c, jaw, points);
  for (int eye = 0; eye < 2; ++eye) {
    const Vec3 centre = eye_centre(eye == 0 ? 1 : -1);
    const float cheek = std::min(1.0f, 0.5f * c[smile_[eye]] + 0.6f * c[cheek_raise_[eye]] + 0.7f * c[squint_[eye]]);
    lids_[eye].pose(motion_, c, eyes[eye].turn({0, 0, 1}), eyes[eye](centre) - centre, cheek, points);
  }
  eyes_.pose(motion_, c, eyes, points);
  bend_.pose(motion_, c, points);
}

}  // namespace sample_face
