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
#include "bake/measure/frame_maxima.h"
#include "bake/measure/histogram.h"
#include "figures/error_figures.h"
#include "figures/quality_figures.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

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
    FrameSetErrors errors() const;
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
  std::vector<FrameMaxima> region_maxima_;  // and last of vertices in no region
  std::vector<float> squares_;  // by vertex, of the frame added last
  std::vector<ControlPart> controls_;
  std::vector<std::vector<float>> past_;  // error vectors of up to two frames before
};

}  // namespace fb::bake
