// Where another mesh, or markers, lie on the face.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "base/parallel.h"
#include "solve/sampled_surface.h"
#include "solve/similarity.h"

namespace fb::tool {

struct AlignmentOptions {
  // Units of the face in a unit of the other. None, for surfaces alone: it is found by their sizes.
  std::optional<double> scale{};
  // The factor by which the scale that is found may differ from `scale`, for people of other sizes; 1: not at all.
  double scale_range = 1;
  // Where to begin, nowhere else: what somebody laid roughly by hand, or an alignment of the whole that a part is to
  // refine. Its scale counts as `scale` where that is not given.
  std::optional<Similarity> start{};
  Parallel parallel{};
};

struct Alignment {
  Similarity to_face;
  double rms = 0;   // distance of the kept pairs from the surface, in units of the face
  double kept = 0;  // share of the sampled points that were kept, of the side that the other covers more of
  // Of the best orientation that is turned by more than 30 degrees from this one, its score over this one's: near 1,
  // the alignment may as well be that one. Infinite where there is none.
  double rival = 0;
};

// Below this, an alignment is to be looked at: Alignment::rival.
inline constexpr double clear_rival = 1.25;

// Moves a mesh onto another by iterating closest points (Besl and McKay, "A method for registration of 3-D shapes",
// PAMI 1992; Chen and Medioni, "Object modelling by registration of multiple range images", 1992, for the last steps,
// in which points slide along planes). It starts from the 24 orientations with axes along axes and from principal axes,
// sizes and places by bounding boxes, never from mirror images, goes on with the best, and leaves out the pairs that
// keep_closest() says. Both surfaces are sampled. Deterministic. Fails with bad_data where nothing comes near.
Alignment align_surfaces(const SampledSurface& other, const SampledSurface& face, const AlignmentOptions& options);

// The same for markers on the skin of a face: points, 4 of them at least, of which some may be off the surface. They
// start before the face. up_axis: the face's, "y" or "z". height: of the markers' middles over the skin, in units of
// the face. Fails with invalid_argument without options.scale or start.
Alignment align_points(std::span<const Vector3> points, const SampledSurface& face, const std::string& up_axis,
                       double height, const AlignmentOptions& options);

// Metres in a unit in which points spread over a face have these positions: of millimetres, centimetres and metres, the
// one by which they are about 20 cm apart. For files that name no unit.
double likely_metres_per_unit(std::span<const Vector3> points);

}  // namespace fb::tool
