// The joints that the controls move, and what follows them: the jaw and the two eyes. The tongue follows the jaw: where
// its own joints turn it, it mostly lies on teeth and lip, and is not where they take it (with them, the worst vertex
// of the quickstart's face is off by 3.0e-2 of the diagonal instead of 2.1e-2, its mse 3.4e-7 instead of 1.55e-7).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "face_mesh.h"
#include "motion.h"

namespace sample_face {

// At rest its axes are those of space.
struct FaceJoint {
  const char* name;
  Vec3 origin;
  std::uint32_t numbers;  // FB_JOINT_... or-ed: how the controls move it
};

inline constexpr int kFaceJoints = 3;

// Jaw, left eye, right eye.
const std::array<FaceJoint, kFaceJoints>& face_joints();

// By vertex, the joint that it follows, and by how much, at most 1: the rest of it stays.
struct FaceSkin {
  std::vector<std::uint16_t> joints;
  std::vector<float> weights;
};

// jaw: weight of the jaw on each vertex.
FaceSkin face_skin(const FaceMesh& mesh, const std::vector<float>& jaw);

// Where the joints are: 12 numbers each, three rows of axes and origin. May be called from several threads at once.
void joint_frames(const MotionControls& m, const float* controls, float* frames);

}  // namespace sample_face
