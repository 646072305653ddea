// What an eye sees of a face's errors besides their size: shading, flicker, seams, and where and when they are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/face_parts.h"
#include "bake/measure/histogram.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Errors of one frame, over D^2 and D (see Errors).
struct FrameErrors {
  float mse = 0, max = 0;
};

// Errors of a part of all measured vertices or frames, over D^2 and D.
struct PartErrors {
  std::string name;
  std::size_t count = 0;  // vertices or frames
  double mse = 0, max = 0;
};

// With e the difference vector of a vertex to its true place, over D, and D the rest mesh's diagonal.
struct Quality {
  // Degrees between area-weighted vertex normals, over vertices that have a polygon which is no line or point.
  double normal_rms = 0, normal_p99 = 0;
  // Root mean square of |e(t-1) - 2 e(t) + e(t+1)| over consecutive frames of shots; no shot of 3 frames: no frames.
  double jitter = 0;
  std::size_t jitter_frames = 0;
  // Root mean square of |e(i) - e(j)| over edges i-j of polygons: between parts, and inside, where every border edge
  // stands for the edges inside the two parts that it joins: a seam is what stands out from what is around it. No part
  // meets another: no border edges, and inside are all edges inside parts.
  double border_jump = 0, inside_jump = 0;
  std::size_t border_edges = 0;
  std::vector<PartErrors> regions;   // the face's parts; those without vertices are left out
  std::vector<PartErrors> controls;  // frames in which a control is beyond half its reach; those without are left out
  std::vector<float> vertex_rms;     // one a vertex
  FaceParts parts;
};

// What is the same in every frame.
struct QualityBasis {
  QualityBasis(const Mesh& rest, const RigSchema& schema, FaceParts parts);

  RigSchema schema;
  double diagonal;
  FaceParts parts;
  std::vector<std::uint32_t> triangles;
  std::vector<std::array<std::uint32_t, 2>> borders, insides;  // edges between parts, and inside one
  std::vector<double> inside_weights;  // one a part: of its inside edges' squared jump, each; see Quality::inside_jump
};

// Sums over frames, joined with `append` in order as ErrorSums are. The basis must outlive it.
class QualitySums {
 public:
  explicit QualitySums(const QualityBasis& basis) : basis_(&basis) {}

  // A frame of a shot that is only looked at for the flicker of those after it.
  void lead_in(std::span<const float> predicted, std::span<const float> truth);
  // `shot`: it follows in time what was added or led in before.
  void add_frame(std::span<const float> controls, std::span<const float> predicted, std::span<const float> truth,
                 bool shot);
  void append(const QualitySums& later);
  Quality figures() const;
  const std::vector<FrameErrors>& frames() const { return frames_; }  // in the order they were added

 private:
  struct Part {
    std::size_t frames = 0;
    double squares = 0, worst = 0;
  };
  FrameErrors add_vertices(const std::vector<float>& error);
  void add_controls(std::span<const float> controls, const FrameErrors& frame);
  void add_jumps(const std::vector<float>& error);
  void add_normals(std::span<const float> predicted, std::span<const float> truth);
  void add_jitter(std::vector<float> error, bool count);

  const QualityBasis* basis_;
  std::size_t jitter_frames_ = 0, normals_ = 0;
  double border_squares_ = 0, inside_squares_ = 0, normal_squares_ = 0, jitter_squares_ = 0;
  Histogram angles_;  // degrees
  std::vector<FrameErrors> frames_;
  std::vector<double> vertex_squares_;
  std::vector<float> vertex_worst_;
  std::vector<Part> controls_;
  std::vector<std::vector<float>> past_;  // error vectors of up to two frames before
};

}  // namespace fb::bake
