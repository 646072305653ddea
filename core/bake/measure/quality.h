// Visible errors besides distances: shading (normals), jitter, seams; and errors by region, control, vertex and frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/contact.h"
#include "bake/measure/face_parts.h"
#include "bake/measure/histogram.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Errors of one frame, over D^2 and D (see Errors).
struct FrameErrors {
  float mse = 0, max = 0;
  std::uint32_t worst_vertex = 0;
  // What the face itself says, see ExpectedErrors: rms of its vertices, and controls outside of what was trained.
  float expected = 0;
  std::uint32_t outside = 0;
};

// Errors of a part of all measured vertices or frames, over D^2 and D.
struct PartErrors {
  std::string name;
  std::size_t count = 0;  // vertices or frames
  double mse = 0, max = 0;
};

// Errors of the frames in which a control is beyond half its reach: of the whole face, and, where others are off rest
// too, of what the control moves.
struct ControlQuality {
  PartErrors all;            // count: those frames
  std::size_t vertices = 0;  // that the control alone moves, see FaceMap; all, if it alone moves none
  PartErrors combined;       // of those vertices, in the frames in which another control is off rest
};

// With e the error vector of a vertex, predicted - true, over D, the rest mesh's bounding-box diagonal.
struct Quality {
  // Degrees between area-weighted vertex normals, over vertices with a polygon that has an area.
  double normal_rms = 0, normal_p99 = 0;
  // Root mean square of |e(t-1) - 2 e(t) + e(t+1)| over consecutive frames of shots of 3 frames or more; jitter_frames
  // is 0 without any.
  double jitter = 0;
  std::size_t jitter_frames = 0;
  // Root mean square of |e(i) - e(j)| over edges i-j of polygons: of edges between parts, and of edges inside a part.
  // The latter are weighted so that each border edge counts the edges inside the two parts it joins equally: a seam is
  // a border_jump above inside_jump. Without border edges inside_jump is over all edges inside parts.
  double border_jump = 0, inside_jump = 0;
  std::size_t border_edges = 0;
  ContactErrors contact;                 // of every contact_step-th frame
  std::vector<PartErrors> regions;       // parts of the face that have vertices
  std::vector<ControlQuality> controls;  // those that are beyond half their reach in some frame
  std::vector<float> vertex_rms;         // one a vertex
  FaceParts parts;
};

// What all frames share.
struct QualityBasis {
  // `moved`: the vertices that each control moves alone; all of them where the list is empty or missing.
  QualityBasis(const Mesh& rest, const RigSchema& schema, FaceParts parts,
               std::vector<std::vector<std::uint32_t>> moved = {});

  RigSchema schema;
  double diagonal;
  FaceParts parts;
  std::vector<std::vector<std::uint32_t>> moved;
  std::vector<std::uint32_t> triangles;
  ContactFinder contact;
  std::size_t contact_step = 1;                                // contact is searched in every so many frames
  std::vector<std::array<std::uint32_t, 2>> borders, insides;  // edges between parts, and inside one
  std::vector<double>
      inside_weights;  // by part: weight of the squared jump of an inside edge, see Quality::inside_jump
};

// Sums over frames; partial sums are joined with `append` in order, like ErrorSums. The basis must outlive it.
class QualitySums {
 public:
  explicit QualitySums(const QualityBasis& basis) : basis_(&basis) {}

  // A frame of a shot before those that are measured: only for the second differences of jitter.
  void add_warm_up(std::span<const float> predicted, std::span<const float> truth);
  // `shot`: the frame follows in time the one added (or warmed up with) before. `contact`: look for touching surfaces,
  // which takes longer than all else.
  void add_frame(std::span<const float> controls, std::span<const float> predicted, std::span<const float> truth,
                 bool shot, bool contact = true);
  void append(const QualitySums& later);
  Quality figures() const;
  const std::vector<FrameErrors>& frames() const { return frames_; }  // in the order they were added

 private:
  struct Part {
    std::size_t frames = 0;
    double squares = 0, worst = 0;

    void add(double mse, double max);
    void append(const Part& later);
    PartErrors errors(const std::string& name) const;
  };
  struct ControlPart {
    Part all, combined;
  };
  FrameErrors add_vertices(const std::vector<float>& error);
  FrameErrors errors_where_moved(std::size_t control, const FrameErrors& frame) const;
  void add_controls(std::span<const float> controls, const FrameErrors& frame);
  void add_jumps(const std::vector<float>& error);
  void add_normals(const std::vector<Vector3>& predicted, const std::vector<Vector3>& truth);
  void add_jitter(std::vector<float> error, bool count);

  const QualityBasis* basis_;
  std::size_t jitter_frames_ = 0, normals_ = 0;
  double border_squares_ = 0, inside_squares_ = 0, normal_squares_ = 0, jitter_squares_ = 0;
  Histogram angles_;  // degrees
  ContactSums contact_;
  std::vector<FrameErrors> frames_;
  std::vector<double> vertex_squares_;
  std::vector<float> vertex_worst_;
  std::vector<float> squares_;  // by vertex, of the frame added last
  std::vector<ControlPart> controls_;
  std::vector<std::vector<float>> past_;  // error vectors of up to two frames before
};

}  // namespace fb::bake
