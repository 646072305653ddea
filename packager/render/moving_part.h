#pragma once

#include <optional>
#include <span>

#include "render/camera.h"
#include "render/mesh_view.h"

namespace fb::tool {

// Finds the part of a mesh that moves: the face of a body.
class MovingPart {
 public:
  explicit MovingPart(const MeshView& rest);

  // Points of a pose, 3 x vertices. A vertex moves if it is off rest by more than 0.002 of the mesh's diagonal.
  void add(std::span<const float> points);
  // The box of what moves in these poses and half its size more at every side; none if nothing does, or if what does is
  // more than 0.35 of the mesh, by their diagonals: a picture then shows the whole.
  std::optional<BoundingBox> region() const;

 private:
  std::span<const float> rest_;
  double diagonal_;
  BoundingBox box_;
};

}  // namespace fb::tool
