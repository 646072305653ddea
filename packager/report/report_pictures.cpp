// The sections of pictures: the paper's Figures 1 and 3, the worst frames, and errors over the face.
#include <algorithm>
#include <cmath>
#include <map>

#include "base/status.h"
#include "render/colour_map.h"
#include "render/montage.h"
#include "render/png_file.h"
#include "render/pose_renderer.h"
#include "report/report_view.h"

namespace fb::tool {
namespace {

constexpr Resolution resolution = {460, 575, 3};
constexpr std::size_t expressive_frames = 4, candidate_frames = 1000, worst_shown = 4, error_maps_shown = 4;
constexpr double moving = 2e-3;  // of the diagonal: vertices that move less need not be in the picture

MeshView rest_mesh(const facebaker::SourceView& source) {
  const fb_source_info& info = source.info();
  return {{info.rest_positions, 3 * std::size_t(info.vertex_count)},
          {info.polygon_sizes, info.polygon_count},
          {info.polygon_corners, info.polygon_corner_count}};
}

// A view of the part of the mesh that moves in these frames, so that the face of a whole body fills the picture.
View view_of_motion(const facebaker::SourceView& source, const std::vector<FrameAddress>& frames) {
  const float* rest = source.info().rest_positions;
  const double still = moving * source.info().diagonal;
  BoundingBox box{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (const FrameAddress& at : frames) {
    const std::vector<float> points = source.read(static_cast<std::uint32_t>(at.clip), at.frame, 1);
    for (std::size_t v = 0; v < points.size() / 3; ++v) {
      const Vector3 p = vector_at(rest, v);
      if (length(vector_at(points.data(), v) - p) <= still) continue;
      box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
      box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
    }
  }
  View view;
  if (box.low.x <= box.high.x) view.region = box;
  return view;
}

// Draws frames of the source beside the same frames of methods. Frames are addressed by the source's clips.
class FrameRenderer {
 public:
  // `framed`: frames whose motion the camera must show.
  FrameRenderer(const facebaker::SourceView& source, const std::vector<FrameAddress>& framed,
                const std::filesystem::path& folder, const Parallel& parallel)
      : source_(source),
        folder_(folder),
        renderer_(rest_mesh(source), source.info().up_axis, view_of_motion(source, framed), resolution, parallel) {}

  FrameAddress find(const std::string& clip, std::size_t frame) const {
    for (std::uint32_t c = 0; c < source_.info().clip_count; ++c)
      if (source_.clip(c).name == clip) return {c, frame};
    fail(Status::internal, "the source has no clip \"%s\", which was measured", clip.c_str());
  }
  std::string name(const FrameAddress& at) const {
    return format("%s, frame %zu", source_.clip(static_cast<std::uint32_t>(at.clip)).name, at.frame);
  }

  // Writes a picture of the true rig, these methods and their errors.
  PoseRenderer::Comparison write_comparison(const std::string& file, const FrameAddress& at, const ReportView& view,
                                            const std::vector<const MethodFigures*>& methods) {
    const auto clip = static_cast<std::uint32_t>(at.clip);
    const float* controls = source_.clip(clip).controls + at.frame * source_.info().control_count;
    const std::vector<float> reference = source_.read(clip, at.frame, 1);
    std::vector<std::vector<float>> posed;
    std::vector<PoseRenderer::Pose> faces;
    for (const MethodFigures* method : methods) posed.push_back(evaluate(*method, controls));
    for (std::size_t m = 0; m < methods.size(); ++m) faces.push_back({view.label(*methods[m]), posed[m]});
    PoseRenderer::Comparison comparison = renderer_.draw_comparison({"true rig", reference}, faces, 0);
    write_png(folder_ / file, comparison.image);
    return comparison;
  }

  Image draw_rest(std::span<const float> scalars, float scale_max) const {
    return renderer_.draw_scalars(rest_mesh(source_).points, scalars, scale_max);
  }
  void write(const std::string& file, const Image& image) const { write_png(folder_ / file, image); }

 private:
  std::vector<float> evaluate(const MethodFigures& method, const float* controls) {
    auto found = models_.find(&method);
    if (found == models_.end())
      found = models_.try_emplace(&method, method.archive.data(), method.archive.size()).first;
    facebaker::Scratch scratch(found->second);
    std::vector<float> points(3 * std::size_t(found->second.vertex_count()));
    scratch.evaluate(controls, points.data());
    return points;
  }

  facebaker::SourceView source_;
  std::filesystem::path folder_;
  PoseRenderer renderer_;
  std::map<const MethodFigures*, facebaker::Model> models_;
};

std::string errors_text(const PoseRenderer::Comparison& comparison, const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += format("%s %s: rms %.1e, worst vertex %.1e.", i ? " " : "", names[i].c_str(), comparison.differences[i].rms,
                   comparison.differences[i].max);
  return text;
}

// Up to about candidate_frames of the measured frames, evenly spaced.
std::vector<FrameAddress> candidates_of(const facebaker::SourceView& source, const std::vector<ClipErrors>& measured) {
  std::vector<FrameAddress> candidates;
  std::size_t total = 0;
  for (const ClipErrors& clip : measured) total += clip.errors.frames;
  const std::size_t step = std::max<std::size_t>(1, total / candidate_frames);
  for (const ClipErrors& clip : measured)
    for (std::uint32_t c = 0; c < source.info().clip_count; ++c)
      if (source.clip(c).name == clip.name)
        for (std::size_t f = 0; f < clip.errors.frames; f += step) candidates.push_back({c, f});
  return candidates;
}

// Control values less those at rest, in units of the larger distance from rest to an end of the range.
std::vector<float> normalised_controls(const facebaker::SourceView& source, const FrameAddress& at) {
  const std::uint32_t width = source.info().control_count;
  const float* values = source.clip(static_cast<std::uint32_t>(at.clip)).controls + at.frame * width;
  std::vector<float> normalised;
  for (std::uint32_t c = 0; c < width; ++c) {
    const fb_control control = source.control(c);
    const float reach = std::max(control.maximum - control.rest, control.rest - control.minimum);
    normalised.push_back((values[c] - control.rest) / reach);
  }
  return normalised;
}

// Farthest-point sampling of the measured frames in the space of normalised controls: the first frame is the farthest
// from rest, each next one the farthest from those before it.
std::vector<FrameAddress> pick_expressive(const facebaker::SourceView& source,
                                          const std::vector<ClipErrors>& measured) {
  const std::vector<FrameAddress> candidates = candidates_of(source, measured);
  std::vector<std::vector<float>> controls;
  for (const FrameAddress& at : candidates) controls.push_back(normalised_controls(source, at));
  std::vector<FrameAddress> picked;
  std::vector<double> distances;  // squared, of candidates to the nearest picked one; to rest while there is none
  for (const std::vector<float>& pose : controls) {
    double squares = 0;
    for (const float value : pose) squares += double(value) * value;
    distances.push_back(squares);
  }
  while (picked.size() < std::min(expressive_frames, candidates.size())) {
    const auto best =
        static_cast<std::size_t>(std::max_element(distances.begin(), distances.end()) - distances.begin());
    picked.push_back(candidates[best]);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      double squares = 0;
      for (std::size_t c = 0; c < controls[i].size(); ++c) {
        const double d = double(controls[i][c]) - controls[best][c];
        squares += d * d;
      }
      distances[i] = picked.size() == 1 ? squares : std::min(distances[i], squares);
    }
  }
  return picked;
}

void add_figure_1(Html& page, const ReportView& view, FrameRenderer& frames) {
  const MethodFigures* linear = view.linear();
  if (!linear) return;
  const auto worst =
      std::max_element(linear->clips.begin(), linear->clips.end(),
                       [](const ClipErrors& a, const ClipErrors& b) { return a.errors.max < b.errors.max; });
  const FrameAddress at = frames.find(worst->name, worst->errors.worst_frame);
  const auto comparison = frames.write_comparison("figure_1.png", at, view, {&view.ours(), linear});
  page.heading("Figure 1: against linear blendshapes");
  page.picture(
      "figure_1.png",
      "The frame in which linear blendshapes are furthest off: " + frames.name(at) +
          ". From the left: the true rig, ours, linear blendshapes; then their errors as fractions of the diagonal. " +
          errors_text(comparison, {view.label(view.ours()), view.label(*linear)}));
}

void add_figure_3(Html& page, const ReportView& view, const std::vector<FrameAddress>& expressive,
                  FrameRenderer& frames, Progress& progress) {
  std::vector<const MethodFigures*> faces = {&view.ours()};
  if (view.backlot()) faces.push_back(view.backlot());
  std::vector<std::string> names;
  for (const MethodFigures* face : faces) names.push_back(view.label(*face));
  page.heading("Figure 3: posed faces");
  page.paragraph("Measured frames that are far from rest and from each other, whatever their errors.");
  progress.begin("drawing posed faces", expressive.size());
  for (std::size_t i = 0; i < expressive.size(); ++i) {
    const std::string file = format("figure_3_%zu.png", i + 1);
    const auto comparison = frames.write_comparison(file, expressive[i], view, faces);
    page.picture(file, frames.name(expressive[i]) + ". " + errors_text(comparison, names));
    progress.step(i + 1);
  }
}

void add_worst_frames(Html& page, const ReportView& view, FrameRenderer& frames, Progress& progress) {
  page.heading("Worst frames of " + view.label(view.ours()));
  std::vector<FrameAddress> worst = view.ours().worst_frames;
  worst.resize(std::min(worst.size(), worst_shown));
  progress.begin("drawing worst frames", worst.size());
  for (std::size_t i = 0; i < worst.size(); ++i) {
    const FrameAddress at = frames.find(view.ours().clips.at(worst[i].clip).name, worst[i].frame);
    const std::string file = i == 0 ? "worst.png" : format("worst_%zu.png", i + 1);
    const auto comparison = frames.write_comparison(file, at, view, {&view.ours()});
    page.picture(file, frames.name(at) + ". " + errors_text(comparison, {view.label(view.ours())}));
    progress.step(i + 1);
  }
}

void add_error_maps(Html& page, const ReportView& view, FrameRenderer& frames) {
  std::vector<Panel> panels;
  for (const MethodFigures& method : view.methods()) {
    const bool shown = method.use == view.ours().use && method.quality;
    const bool last_panel = panels.size() + 1 == error_maps_shown;  // kept for ours
    if (!shown || (last_panel && &method < &view.ours())) continue;
    if (panels.size() == error_maps_shown) break;
    const std::vector<float>& rms = method.quality->vertex_rms;
    const float worst = *std::max_element(rms.begin(), rms.end()), scale_max = round_scale(worst);
    panels.push_back(
        {frames.draw_rest(rms, scale_max), format("%s\nworst %.1e", view.label(method).c_str(), worst), scale_max});
  }
  if (panels.empty()) return;
  frames.write("error_map.png", make_montage(panels));
  page.heading("Error over the face");
  page.picture("error_map.png",
               "Root mean square error of each vertex over all measured frames, as a fraction of the "
               "diagonal. Each picture has a scale of its own.");
}

}  // namespace

void add_pictures(Html& page, const ReportView& view, const facebaker::SourceView& source,
                  const std::filesystem::path& folder, const Parallel& parallel, Progress& progress) {
  if (!view.measured()) return;
  const std::vector<FrameAddress> expressive = pick_expressive(source, view.ours().clips);
  FrameRenderer frames(source, expressive, folder, parallel);
  add_figure_1(page, view, frames);
  add_figure_3(page, view, expressive, frames, progress);
  add_worst_frames(page, view, frames, progress);
  add_error_maps(page, view, frames);
}

}  // namespace fb::tool
