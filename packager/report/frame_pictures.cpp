#include "report/frame_pictures.h"

#include <algorithm>

#include "base/length_units.h"
#include "base/status.h"
#include "export/character_appearance.h"
#include "render/moving_part.h"
#include "render/png_file.h"

namespace fb::tool {
namespace {

constexpr Resolution resolution = {460, 575, 3};
// Over D: the scale ends there at least, so that a good face looks good.
constexpr double least_end = 0.01;

// Whole, or of a face that is a small part of a body, what moves in these frames.
View view_of(const facebaker::SourceView& source, const std::vector<PosedFrame>& frames) {
  MovingPart part(rest_mesh(source));
  for (const PosedFrame& frame : frames) part.add(frame.truth);
  View view;
  view.region = part.region();
  return view;
}

// With the materials that a face was baked with. Its polygons are those of the source.
std::shared_ptr<const Appearance> appearance_of(const MethodReport& method) {
  const facebaker::Model model(method.archive.data(), method.archive.size());
  return appearance_of(CharacterView(model));
}

MeshPoses all_poses(const std::vector<PosedFrame>& frames) {
  MeshPoses poses;
  for (const PosedFrame& frame : frames) {
    poses.push_back(frame.truth);
    poses.insert(poses.end(), frame.posed.begin(), frame.posed.end());
  }
  return poses;
}

}  // namespace

MeshView rest_mesh(const facebaker::SourceView& source) {
  const fb_source_info& info = source.info();
  return {{info.rest_positions, 3 * std::size_t(info.vertex_count)},
          {info.polygon_sizes, info.polygon_count},
          {info.polygon_corners, info.polygon_corner_count}};
}

FrameAddress FrameReader::find(const std::string& clip, std::size_t frame) const {
  for (std::uint32_t c = 0; c < source_.info().clip_count; ++c)
    if (source_.clip(c).name == clip) return {c, frame};
  fail(Status::internal, "the source has no clip \"%s\", which was measured", clip.c_str());
}

PosedFrame FrameReader::read(const FrameAddress& at, const std::vector<const MethodReport*>& methods) {
  const auto clip = static_cast<std::uint32_t>(at.clip);
  PosedFrame frame{
      format("%s, frame %zu", source_.clip(clip).name, at.frame), methods, source_.read(clip, at.frame, 1), {}};
  const float* controls = source_.clip(clip).controls + at.frame * source_.info().control_count;
  for (const MethodReport* method : methods) frame.posed.push_back(evaluate(*method, controls));
  return frame;
}

std::vector<float> FrameReader::evaluate(const MethodReport& method, const float* controls) {
  auto found = models_.find(&method);
  if (found == models_.end()) found = models_.try_emplace(&method, method.archive.data(), method.archive.size()).first;
  facebaker::Scratch scratch(found->second);
  std::vector<float> points(3 * std::size_t(found->second.vertex_count()));
  scratch.evaluate(controls, points.data());
  return points;
}

FramePictures::FramePictures(const ReportView& view, const facebaker::SourceView& source,
                             const std::vector<PosedFrame>& frames, double largest_error,
                             const std::filesystem::path& folder, const Parallel& parallel)
    : report_(view),
      source_(source),
      folder_(folder),
      parallel_(parallel),
      view_(view_of(source, frames)),
      renderer_(rest_mesh(source), all_poses(frames), source.info().up_axis, view_, resolution, parallel,
                appearance_of(view.ours())) {
  for (const PosedFrame& frame : frames)
    for (const std::vector<float>& posed : frame.posed)
      largest_error = std::max(largest_error, renderer_.difference(frame.truth, posed).max);
  const ShownUnit unit = shown_unit(view.figures().units);
  bar_ = {{round_scale(static_cast<float>(std::max(largest_error, least_end))), true},
          view.figures().diagonal * unit.per_unit,
          unit.name};
}

std::string FramePictures::write_comparison(const std::string& file, const PosedFrame& frame) const {
  std::vector<PoseRenderer::Pose> faces;
  for (std::size_t m = 0; m < frame.methods.size(); ++m)
    faces.push_back({report_.label(*frame.methods[m]), frame.posed[m]});
  const PoseRenderer::Comparison comparison = renderer_.draw_comparison({"true rig", frame.truth}, faces, bar_);
  write(file, comparison.image);
  std::string text;
  for (std::size_t m = 0; m < faces.size(); ++m) {
    const PoseRenderer::Difference& difference = comparison.differences[m];
    text += format("%s%s: rms %.1e, worst vertex %.1e (%.2g %s), vertex %zu", m ? " " : "", faces[m].caption.c_str(),
                   difference.rms, difference.max, difference.max * bar_.length, bar_.units.c_str(), difference.vertex);
    const std::string region = report_.region_of(difference.vertex);
    text += region.empty() ? "." : " in " + region + ".";
  }
  return text;
}

Image FramePictures::draw_rest(std::span<const float> scalars) const {
  return renderer_.draw_scalars(rest_mesh(source_).points, scalars, bar_.scale);
}

Image FramePictures::draw_parts(std::span<const std::size_t> parts, std::size_t count) const {
  const MeshView rest = rest_mesh(source_);
  std::vector<Panel> panels;
  for (const float yaw : {0.0f, 55.0f}) {
    View view = view_;
    view.yaw = yaw;
    const PoseRenderer renderer(rest, {}, source_.info().up_axis, view, resolution, parallel_);
    panels.push_back({renderer.draw_parts(rest.points, parts, count), yaw == 0 ? "front" : "left side", {}});
  }
  return make_montage(panels);
}

void FramePictures::write(const std::string& file, const Image& image) const {
  write_png(folder_ / file, image);
}

}  // namespace fb::tool
