// Pictures of posed faces as reports and `pose` show them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "model/mesh.h"
#include "render/camera.h"
#include "render/image.h"
#include "render/rasterizer.h"

namespace fb {

// Draws many poses of one mesh with one camera, framed on the rest pose with room for a jaw to open.
class Portrait {
 public:
  Portrait(const Mesh& rest, const std::string& up_axis, View view, const Canvas& canvas, const Parallel& parallel);

  Image draw(std::span<const float> points) const;

  struct Difference {
    Image image;
    double rms = 0, max = 0;  // over the diagonal
  };
  // Three panels: the truth, what the archive gives, and the distance between them in fractions of the diagonal.
  // full_scale: the end of the error map's scale; 0: a round number above the largest error.
  Difference draw_beside(std::span<const float> truth, std::span<const float> predicted, float full_scale) const;

 private:
  std::vector<std::uint32_t> triangles_;
  double diagonal_;
  Canvas canvas_;
  Parallel parallel_;
  Camera camera_;
};

}  // namespace fb
