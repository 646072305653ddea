// The part of the rig that turns, slides and touches. Each deformer is made once from the rest mesh and then only read.
// All work in place on the posed points of the whole mesh, in the order in which Rig::pose calls them.
#pragma once

#include <array>
#include <vector>

#include "controls.h"
#include "face_mesh.h"

namespace sample_face {

// A rotation about a point, and a shift.
struct Motion {
  std::array<Vec3, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vec3 shift;

  Vec3 turn(Vec3 v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
  Vec3 operator()(Vec3 p) const { return turn(p) + shift; }
};

// Turns by `pitch` about x (positive: +z towards -y), then `yaw` about y (positive: +z towards +x), then `roll` about z
// (positive: +x towards +y), in radians, about `pivot`; then moves by `slide`.
Motion motion_about(Vec3 pivot, float pitch, float yaw, float roll, Vec3 slide = {});
// First b, then a.
Motion operator*(const Motion& a, const Motion& b);

struct Weighted {
  Index vertex;
  float weight;
};

// Jaw: opens about the hinge while sliding forward, swings, twists; the lower teeth and the tongue go along.
class Jaw {
 public:
  Jaw(const FaceMesh& mesh, const std::vector<float>& weights);
  static Motion motion(const MotionControls& m, const float* controls);
  void pose(const Motion& jaw, Vec3* points) const;

 private:
  std::vector<Weighted> moved_;
};

// Lips: rolling in and out segment by segment, fullness; the mouth swinging on the face; sticking, zipping and
// touching.
class Lips {
 public:
  explicit Lips(const FaceMesh& mesh);
  void roll(const MotionControls& m, const float* controls, Vec3* points) const;                      // before the jaw
  void swing(const MotionControls& m, const float* controls, Vec3* points) const;                     // after the jaw
  void touch(const MotionControls& m, const float* controls, const Motion& jaw, Vec3* points) const;  // last

 private:
  // A column of one lip with the opposite column of the other.
  struct Pair {
    int upper, lower;
    float across;
    std::array<float, 3> gap;  // at rest, ring by ring of those that meet
  };
  std::array<Ring, kMouthRings> rings_;
  std::vector<Pair> pairs_;
  std::vector<Weighted> swung_;
  std::array<Vec3, kMouthColumns> tangents_, outwards_;
};

// Lids of one eye: slide over the eyeball and its cornea, meet without crossing.
class Lids {
 public:
  Lids(const FaceMesh& mesh, int eye);
  // `gaze` is the eye's unit line of sight, `shift` where its centre moved to.
  // `cheek`, 0 to 1, is how far the cheek pushes the lower lid up.
  void pose(const MotionControls& m, const float* controls, Vec3 gaze, Vec3 shift, float cheek, Vec3* points) const;

 private:
  struct Column {
    float elevation, sine;  // of the lid's edge at rest; sine of the angle round the opening
    int opposite;           // column of the other lid that it meets
    float tilt;             // -1 at the inner corner, 1 at the outer
    std::array<float, 5> segments;
  };
  int eye_;
  Vec3 centre_;
  std::array<Ring, kLidRings> rings_;
  std::array<Column, kLidColumns> columns_;
  std::array<std::array<float, kLidColumns>, kLidRings> off_,
      bulge_;  // from the eye's surface at rest; the cornea's part
};

// Eyeballs turn; pupils open and close.
class Eyes {
 public:
  explicit Eyes(const FaceMesh& mesh);
  // Where eye `eye` looks and how far it stands out.
  static Motion motion(const MotionControls& m, const float* controls, int eye);
  void pose(const MotionControls& m, const float* controls, const std::array<Motion, 2>& eyes, Vec3* points) const;

 private:
  std::array<Span, 2> spans_;
  std::vector<Vec3> rest_[2];
  std::vector<float> pupil_[2];
};

// Tongue: a chain of four joints that stretches, with width and gutter; then it goes with the jaw.
class Tongue {
 public:
  explicit Tongue(const FaceMesh& mesh);
  void pose(const MotionControls& m, const float* controls, Vec3* points) const;  // before the jaw

 private:
  Span span_;
  std::vector<Vec3> rest_;
  std::vector<float> above_;  // height over the underside
};

// The lower face as a whole: squashes, stretches, bends sideways.
class Bend {
 public:
  explicit Bend(const FaceMesh& mesh);
  void pose(const MotionControls& m, const float* controls, Vec3* points) const;

 private:
  std::vector<Weighted> moved_;
};

}  // namespace sample_face
