#include "face_joints.h"

#include <facebaker/facebaker_character.h>

#include "anatomy.h"

namespace sample_face {
namespace {

constexpr int kJaw = 0, kEyes = 1;

}  // namespace

const std::array<FaceJoint, kFaceJoints>& face_joints() {
  static const std::array<FaceJoint, kFaceJoints> joints = {{
      {"jaw", kJawHinge, FB_JOINT_ROTATE | FB_JOINT_MOVE},
      {"eye_L", eye_centre(1), FB_JOINT_ROTATE | FB_JOINT_MOVE_Z},
      {"eye_R", eye_centre(-1), FB_JOINT_ROTATE | FB_JOINT_MOVE_Z},
  }};
  return joints;
}

FaceSkin face_skin(const FaceMesh& mesh, const std::vector<float>& jaw) {
  FaceSkin skin{std::vector<std::uint16_t>(jaw.size(), kJaw), jaw};
  for (int eye = 0; eye < 2; ++eye)
    for (Index v = mesh.eyes[eye].first; v < mesh.eyes[eye].first + mesh.eyes[eye].count; ++v) {
      skin.joints[v] = std::uint16_t(kEyes + eye);
      skin.weights[v] = 1;
    }
  return skin;
}

void joint_frames(const MotionControls& m, const float* controls, float* frames) {
  const std::array<Motion, kFaceJoints> motions = {Jaw::motion(m, controls), Eyes::motion(m, controls, 0),
                                                   Eyes::motion(m, controls, 1)};
  for (int j = 0; j < kFaceJoints; ++j) {
    const Vec3 origin = motions[j](face_joints()[j].origin);
    for (int row = 0; row < 3; ++row, frames += 4) {
      const Vec3 axes = motions[j].rows[row];
      frames[0] = axes.x;
      frames[1] = axes.y;
      frames[2] = axes.z;
      frames[3] = (&origin.x)[row];
    }
  }
}

}  // namespace sample_face
