// Corrective shapes of the production rig: each is driven by a product of ramps of two or three controls.
#pragma once

#include <vector>

#include "production/production_controls.h"
#include "production/production_mesh.h"

namespace rigs::production {

class CorrectiveDrivers {
 public:
  CorrectiveDrivers(const ControlList& controls, const FaceMesh& mesh);

  // Adds the shapes to the rest points, before bones move them.
  void add(const float* c, Vec* points) const;

 private:
  struct Driver {
    int control;
    float from, to;  // values at which the ramp begins and ends
  };
  struct Offset {
    std::size_t vertex;
    Vec offset;
  };
  struct Shape {
    std::vector<Driver> drivers;
    std::vector<Offset> offsets;
  };

  std::vector<Shape> shapes_;
};

}  // namespace rigs::production
