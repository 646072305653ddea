// The part of the rig that adds shapes: what each control draws, in-betweens, and correctives of controls that act
// together.
#pragma once

#include <array>
#include <vector>

#include "controls.h"
#include "strokes.h"

namespace sample_face {

// A control, or one side of a two-sided one, as a driver: its activation is max(0, sign * value).
struct Driver {
  int control = -1;
  float sign = 1;
};

enum class Law {
  linear,   // the value, with its sign
  side,     // the activation
  between,  // a tent over the activation: 0 at 0, 1 at 1/2, 0 at 1
  product,  // of the activations
  minimum,  // of the activations
};

struct Term {
  Law law = Law::linear;
  std::array<Driver, 3> drivers;
  int driver_count = 1;
  Delta delta;

  float weight(const float* controls) const;
};

// Pose shapes: the animator's expressions.
void add_pose_shapes(const Canvas& canvas, Controls& controls, std::vector<Term>& terms);
// Small local movements of points of the face.
void add_tweakers(const Canvas& canvas, Controls& controls, std::vector<Term>& terms);
// Combinations of what is there already.
void add_correctives(const Canvas& canvas, const Controls& controls, std::vector<Term>& terms);

}  // namespace sample_face
