// Images of posed faces for reports and the command `pose`.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "render/camera.h"
#include "render/image.h"
#include "render/mesh_view.h"
#include "render/montage.h"
#include "render/rasterizer.h"

namespace fb::tool {

// The points of a mesh in some poses.
using MeshPoses = std::vector<std::span<const float>>;

// Draws many poses of one mesh with one camera.
class PoseRenderer {
 public:
  // The camera shows the rest pose and `poses` whole, or of each the vertices that lie in view.region at rest. Mesh and
  // poses are read by the constructor only. appearance: of the triangles of `rest`; null: clay.
  PoseRenderer(const MeshView& rest, const MeshPoses& poses, const std::string& up_axis, const View& view,
               const Resolution& resolution, const Parallel& parallel,
               std::shared_ptr<const Appearance> appearance = nullptr);

  const Camera& camera() const { return camera_; }

  // points: 3 x vertices.
  Image draw(std::span<const float> points) const;

  // The surface coloured by one scalar a vertex.
  Image draw_scalars(std::span<const float> points, std::span<const float> scalars, const ColourScale& scale) const;

  // The surface in the colours of parts (part_colour), with their numbers, from 1, where they are seen. parts: one a
  // vertex; grey from `count` on.
  Image draw_parts(std::span<const float> points, std::span<const std::size_t> parts, std::size_t count) const;

  struct Pose {
    std::string caption;
    std::span<const float> points;
  };
  struct Difference {
    double rms = 0, max = 0;  // of the vertices' distances, over the diagonal
    std::size_t vertex = 0;   // the worst
  };
  struct Comparison {
    Image image;
    std::vector<Difference> differences;  // one for each face compared
  };
  // Of the distances of each vertex, which are added to `distances`, over the diagonal.
  Difference difference(std::span<const float> reference, std::span<const float> face,
                        std::vector<float>* distances = nullptr) const;
  // Side by side: the reference, each of the faces, then the error map of each face with a ring round its worst vertex:
  // its distance to the reference over the diagonal, all on one scale. An end of the scale of 0 stands for a round
  // number above the largest error.
  Comparison draw_comparison(const Pose& reference, const std::vector<Pose>& faces, ColourBar bar) const;

 private:
  void draw_ring(Image& image, Vector3 point) const;

  std::vector<std::uint32_t> triangles_;
  double diagonal_;
  Resolution resolution_;
  Parallel parallel_;
  Camera camera_;
  std::shared_ptr<const Appearance> appearance_;
};

}  // namespace fb::tool
