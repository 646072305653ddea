// Where captured markers sit on the face.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "solve/marker_take.h"
#include "solve/sampled_surface.h"
#include "solve/similarity.h"

namespace fb::tool {

struct PlacedMarker {
  std::string name;
  SurfacePoint point;  // of the face
  float distance = 0;  // from the surface, in the frame it was found in, in units of the face; 0: given
};

struct MarkerPlacement {
  std::vector<PlacedMarker> markers;
  // Sentences on the markers that have no place: not seen in the frame, or too far from the surface.
  std::vector<std::string> notes;
};

// The closest points of the face to the markers of a frame in which it is neutral. to_face: of align_points(). Markers
// that are farther than `bound`, in units of the face, or missing have no place. unit: of the face, for notes. Fails
// with invalid_argument if there is no such frame.
MarkerPlacement place_markers(const MarkerTake& take, std::size_t frame, const Similarity& to_face,
                              const SampledSurface& face, double bound, const std::string& unit);

// Positions of the markers of a frame that are seen, in units of the take, for align_points().
std::vector<Vector3> seen_markers(const MarkerTake& take, std::size_t frame);

// The frame from 0 in which most markers are seen, the first of several: where a neutral face is to be looked for if
// nobody says.
std::size_t fullest_frame(const MarkerTake& take);

// A JSON file: {"markers": {"NAME": {"vertices": [A, B, C], "weights": [a, b, c]}}}; one or two vertices will do, and
// one needs no weight. Weights sum to 1 within 0.001. Other members are left alone. Fails with bad_data, naming file
// and marker; with limit beyond 16 MiB or 4,096 markers; and as read_file does. vertex_count: of the face.
MarkerPlacement read_marker_placement(const std::filesystem::path& path, std::size_t vertex_count);

// Writes such a file, complete or not at all, a marker a line, with "distance_mm" if the unit is known.
void write_marker_placement(const std::filesystem::path& path, const MarkerPlacement& placement,
                            const std::string& unit);

}  // namespace fb::tool
