// What the controls mean to others: names of ARKit's face blendshapes, action units, partners on the other side.
#pragma once

#include <string>
#include <vector>

#include "controls.h"

namespace sample_face {

struct ControlLabels {
  std::string arkit, facs, mirror;  // "": none
};

// Of each control, in their order. A shape of ARKit that takes two controls, or the negative side of one, is not there:
// a name stands for one control, whose 1 is the shape's 1.
std::vector<ControlLabels> label(const Controls& controls);

}  // namespace sample_face
