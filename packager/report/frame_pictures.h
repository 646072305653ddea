// Pictures of frames of a source beside the same frames of methods: one camera and one scale of colours for all.
#pragma once

#include <facebaker/facebaker_bake.hpp>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "render/pose_renderer.h"
#include "report/report_view.h"

namespace fb::tool {

MeshView rest_mesh(const facebaker::SourceView& source);

// A frame as the rig and as methods pose it.
struct PosedFrame {
  std::string name;  // "story, frame 12"
  std::vector<const MethodReport*> methods;
  std::vector<float> truth;
  std::vector<std::vector<float>> posed;  // one a method
};

class FrameReader {
 public:
  explicit FrameReader(const facebaker::SourceView& source) : source_(source) {}

  // By the source's clips.
  FrameAddress find(const std::string& clip, std::size_t frame) const;
  PosedFrame read(const FrameAddress& at, const std::vector<const MethodReport*>& methods);

 private:
  std::vector<float> evaluate(const MethodReport& method, const float* controls);

  facebaker::SourceView source_;
  std::map<const MethodReport*, facebaker::Model> models_;
};

class FramePictures {
 public:
  // frames: all that will be drawn, which the camera shows whole, with the rest mesh; of a face that is a small part of
  // a body, the vertices near those that move. The scale ends above the largest error of these frames, of
  // every method, and `largest_error` (over D), and not below 1 % of D.
  FramePictures(const ReportView& view, const facebaker::SourceView& source, const std::vector<PosedFrame>& frames,
                double largest_error, const std::filesystem::path& folder, const Parallel& parallel);

  const ColourBar& bar() const { return bar_; }
  // Whether the camera leaves out a part of the mesh.
  bool part_of_body() const { return view_.region.has_value(); }

  // Writes a picture of the true rig, the methods and their errors; returns what they are off by and where.
  std::string write_comparison(const std::string& file, const PosedFrame& frame) const;
  // The rest mesh in the colours of scalars.
  Image draw_rest(std::span<const float> scalars) const;
  // The rest mesh in the colours of parts, from the front and from the side.
  Image draw_parts(std::span<const std::size_t> parts, std::size_t count) const;
  void write(const std::string& file, const Image& image) const;

 private:
  const ReportView& report_;
  facebaker::SourceView source_;
  std::filesystem::path folder_;
  Parallel parallel_;
  View view_;
  PoseRenderer renderer_;
  ColourBar bar_;
};

}  // namespace fb::tool
