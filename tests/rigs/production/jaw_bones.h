// Jaw, tongue and neck: chains of bones that rotate, within limits.
#pragma once

#include <vector>

#include "production/face_bone.h"
#include "production/production_controls.h"

namespace rigs::production {

class JawBones {
 public:
  JawBones(ControlList& controls, std::vector<FaceBone>& bones);

  // The jaw with its channels at this fraction: what bones between skull and jaw copy.
  Motion jaw(const float* c, float fraction) const;
  // Tongue and neck.
  void pose(const float* c, std::vector<Motion>& motions) const;

 private:
  struct Link {
    Vec head;
    std::vector<int> rotation;     // channels about x, y and perhaps z
    std::vector<int> translation;  // none, or three channels
    float low, high;               // limits of a rotation, degrees
    std::size_t bone;
  };
  void pose_chain(const std::vector<Link>& chain, Motion parent, const float* c, std::vector<Motion>& motions) const;

  int open_, swing_, twist_, side_, forward_;
  std::vector<Link> tongue_, neck_;
};

}  // namespace rigs::production
