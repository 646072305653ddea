// Pictures of how a target fits the face, for people to judge it by.
#pragma once

#include <string>

#include "base/parallel.h"
#include "render/image.h"
#include "render/mesh_view.h"
#include "render/rasterizer.h"
#include "solve/marker_placement.h"
#include "solve/mesh_correspondence.h"

namespace fb::tool {

struct FitPictureOptions {
  std::string up_axis = "y";  // of the face
  std::string unit;           // of the face
  Resolution resolution = {.width = 420, .height = 520, .samples = 2};
  Parallel parallel{};
};

// From the front and from half the side: the face, coloured by the distance of each vertex to its partner, blue where
// it has none, and the other mesh, aligned, beside it. Vertices that were not asked for are blue, too.
Image draw_mesh_fit(const MeshView& face, const MeshView& other, const Similarity& to_face,
                    const MeshCorrespondence& correspondence, const FitPictureOptions& options);

// From the front and from half the side: the face with a dot where each marker sits, coloured by its distance. what:
// that it is, for the caption.
Image draw_marker_fit(const MeshView& face, const MarkerPlacement& placement, const FitPictureOptions& options,
                      const std::string& what = "distance from the\nsurface where placed");

}  // namespace fb::tool
