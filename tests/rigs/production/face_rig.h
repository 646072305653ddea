// The production rig without its plugin: controls in, vertices out.
//
// It behaves as the rig of a film character does: 303 controls, nearly all of them channels of bones that move a small
// part of the face; chains of bones, limits, shares of the jaw, bones that follow, track and stretch to others, lips
// that slide on the teeth, zip and do not pass through each other, cages round the mouth, and 64 corrective shapes.
// Ranges are wider than any shot uses. All of it is continuous, made of formulas, and needs no data.
#pragma once

#include <vector>

#include "production/corrective_drivers.h"
#include "production/lid_bones.h"
#include "production/lip_bones.h"
#include "production/lip_cage.h"

namespace rigs::production {

class FaceRig {
 public:
  FaceRig();

  const ControlList& controls() const { return controls_; }
  const FaceMesh& mesh() const { return mesh_; }
  const std::vector<Vec>& rest() const { return rest_; }
  // controls: one float a control; points: one a vertex. Thread-safe.
  void pose(const float* controls, Vec* points) const;

 private:
  struct Influence {
    std::size_t bone;
    float weight;
  };
  void bind_skin();

  FaceMesh mesh_;
  ControlList controls_;
  std::vector<FaceBone> bones_;
  JawBones jaw_;
  LipBones lips_;
  SlidingBones sliding_;
  LidBones lids_;
  CorrectiveDrivers correctives_;
  LipCage cage_;
  std::vector<std::vector<Influence>> influences_;  // of each vertex
  std::vector<float> jaw_shares_;                   // of each vertex: of the jaw in what the influences leave
  std::vector<Vec> rest_;
};

}  // namespace rigs::production
