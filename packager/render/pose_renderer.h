// Images of posed faces for reports and the command `pose`.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "render/camera.h"
#include "render/image.h"
#include "render/mesh_view.h"
#include "render/rasterizer.h"

namespace fb::tool {

// Draws many poses of one mesh with one camera, fitted to the rest pose with room for a jaw to open.
class PoseRenderer {
 public:
  // rest is read by the constructor only.
  PoseRenderer(const MeshView& rest, const std::string& up_axis, View view, const Resolution& resolution,
               const Parallel& parallel);

  // points: 3 x vertices.
  Image draw(std::span<const float> points) const;

  // The surface coloured by one scalar a vertex, from 0 to scale_max of the colour map.
  Image draw_scalars(std::span<const float> points, std::span<const float> scalars, float scale_max) const;

  struct Pose {
    std::string caption;
    std::span<const float> points;
  };
  struct Difference {
    double rms = 0, max = 0;  // of the vertices' distances, over the diagonal
  };
  struct Comparison {
    Image image;
    std::vector<Difference> differences;  // one for each face compared
  };
  // Side by side: the reference, each of the faces, then the error map of each face: its distance to the reference over
  // the diagonal, all on one scale. scale_max: the end of that scale; 0: a round number above the largest error.
  Comparison draw_comparison(const Pose& reference, const std::vector<Pose>& faces, float scale_max) const;

 private:
  std::vector<std::uint32_t> triangles_;
  double diagonal_;
  Resolution resolution_;
  Parallel parallel_;
  Camera camera_;
};

}  // namespace fb::tool
