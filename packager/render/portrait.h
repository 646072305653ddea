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

  // The surface coloured by one number a vertex, in the colours of map_colour from 0 to `full`.
  Image draw_field(std::span<const float> points, std::span<const float> field, float full) const;

  struct Posed {
    std::string caption;
    std::span<const float> points;
  };
  struct Difference {
    double rms = 0, max = 0;  // over the diagonal
  };
  struct Comparison {
    Image image;
    std::vector<Difference> differences;  // one for each face compared
  };
  // Side by side: the truth, each of the faces, then for each of them its distance to the truth in fractions of the
  // diagonal, all on one scale. full_scale: the end of that scale; 0: a round number above the largest error.
  Comparison draw_beside(const Posed& truth, const std::vector<Posed>& faces, float full_scale) const;

 private:
  std::vector<std::uint32_t> triangles_;
  double diagonal_;
  Canvas canvas_;
  Parallel parallel_;
  Camera camera_;
};

}  // namespace fb
