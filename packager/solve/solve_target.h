// What a face is solved for: points of it, and where they should be in each frame.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "solve/similarity.h"
#include "solve/surface_point.h"

namespace fb::tool {

struct SolveTarget {
  std::string what;  // for people: "markers of take.trc"
  std::size_t frames = 0;
  double fps = 30;
  // Writes the points of a frame as the target has them, 3 floats each; NaN where one was not measured.
  std::function<void(std::size_t frame, std::vector<float>& points)> read;
  std::vector<SurfacePoint> face_points;  // of the face; empty: every vertex, which is the target's point of its number
  std::vector<SurfacePoint> target_points;  // of the target, one for each of the face
  Similarity to_face;                       // from the target's space and units to the face's
  // What each point is off by where nothing moved, in the space of the face, 3 floats each: it counts as where it
  // should be there. Empty: nothing.
  std::vector<float> offsets;
  std::vector<std::string> notes;  // sentences

  std::size_t points(std::size_t vertices) const { return face_points.empty() ? vertices : face_points.size(); }
  // Where the points should be in a frame, in the space of the face, without offsets; `raw`: room for `read`.
  void find(std::size_t frame, std::vector<float>& raw, std::vector<float>& positions) const;
  // Takes offsets from a frame in which the face is at rest. rest: positions of the face's vertices.
  void set_offsets(std::size_t neutral, std::span<const float> rest);
};

}  // namespace fb::tool
