// The sample face as a rig: mesh, controls, and the posed points for any values of the controls.
#pragma once

#include <array>
#include <vector>

#include "controls.h"
#include "face_mesh.h"
#include "motion.h"
#include "shape_terms.h"

namespace sample_face {

class Rig {
 public:
  Rig();

  const FaceMesh& mesh() const { return mesh_; }
  // The points with all controls at 0, exactly as pose gives them; mesh().points before the deformers' rounding.
  const std::vector<Vec3>& rest() const { return rest_; }
  // How much each vertex follows the jaw.
  const std::vector<float>& jaw_weight() const { return jaw_weight_; }
  const Controls& controls() const { return controls_; }
  const MotionControls& motions() const { return motion_; }
  const std::vector<Term>& terms() const { return terms_; }
  // points: one per vertex. May be called from several threads at once; equal controls give equal bits.
  void pose(const float* controls, Vec3* points) const;

 private:
  FaceMesh mesh_;
  std::vector<float> jaw_weight_;
  Controls controls_;
  MotionControls motion_;
  std::vector<Term> terms_;
  Jaw jaw_;
  Lips lips_;
  std::array<Lids, 2> lids_;
  Eyes eyes_;
  Tongue tongue_;
  Bend bend_;
  std::array<int, 2> smile_{}, cheek_raise_{}, squint_{};  // controls that push the lower lids, left and right
  std::vector<Vec3> rest_;
};

}  // namespace sample_face
