#include "report/report_pictures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "archive/reader.h"
#include "base/status.h"
#include "render/colour_map.h"
#include "render/montage.h"
#include "render/png_file.h"
#include "render/pose_renderer.h"
#include "report/model_mesh.h"
#include "runtime/evaluator.h"

namespace fb::tool {
using namespace archive;
using namespace runtime;
namespace {

constexpr Resolution resolution = {460, 575, 3};
constexpr std::size_t expressive_frames = 4, frames_looked_at = 1000, worst_shown = 4, fields_shown = 4;
constexpr double moving = 2e-3;  // of the diagonal: what moves less need not be in the picture

struct FrameAddress {
  std::size_t clip = 0, frame = 0;  // of the source
};

// A view of the part of the mesh that moves in these frames, so that a face on a body is seen from near.
View view_of(Source& source, const std::vector<FrameAddress>& frames) {
  const std::vector<float>& rest = source.rest().points;
  const double still = moving * source.rest().diagonal();
  BoundingBox box{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  std::vector<float> points(rest.size());
  for (const FrameAddress& at : frames) {
    source.read(at.clip, at.frame, 1, points);
    for (std::size_t v = 0; v < rest.size() / 3; ++v) {
      const Vector3 p = vector_at(rest.data(), v);
      if (length(vector_at(points.data(), v) - p) <= still) continue;
      box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
      box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
    }
  }
  View view;
  if (box.low.x <= box.high.x) view.region = box;
  return view;
}

// Poses the rig and the methods, and draws them.
class Studio {
 public:
  // `shown`: frames whose motion is to be in the pictures.
  Studio(Source& source, const std::vector<FrameAddress>& shown, const std::filesystem::path& folder,
         const Parallel& parallel)
      : source_(source),
        folder_(folder),
        renderer_(mesh_view_of(source.rest()), source.schema().up_axis, view_of(source, shown), resolution, parallel) {}

  const PoseRenderer& renderer() const { return renderer_; }
  FrameAddress find(const std::string& clip, std::size_t frame) const {
    for (std::size_t c = 0; c < source_.clips().size(); ++c)
      if (source_.clips()[c].name == clip) return {c, frame};
    fail(Status::internal, "the clip \"%s\" that was measured is gone", clip.c_str());
  }
  std::string name(const FrameAddress& at) const {
    return format("%s, frame %zu", source_.clips()[at.clip].name.c_str(), at.frame);
  }

  // The rig and these methods in one frame, with what they are off, as a picture of the folder.
  PoseRenderer::Comparison show(const std::string& file, const FrameAddress& at, const ReportView& view,
                                const std::vector<const MethodReport*>& methods) {
    const Clip& clip = source_.clips()[at.clip];
    const std::size_t width = source_.schema().control_count();
    const std::span<const float> controls(&clip.controls[at.frame * width], width);
    std::vector<float> truth(source_.rest().points.size());
    source_.read(at.clip, at.frame, 1, truth);
    std::vector<std::vector<float>> posed;
    std::vector<PoseRenderer::Pose> faces;
    for (const MethodReport* method : methods) posed.push_back(pose(face(*method), controls));
    for (std::size_t m = 0; m < methods.size(); ++m) faces.push_back({view.label(*methods[m]), posed[m]});
    PoseRenderer::Comparison comparison = renderer_.draw_comparison({"true rig", truth}, faces, 0);
    write(file, comparison.image);
    return comparison;
  }
  void write(const std::string& file, const Image& image) const { write_png(folder_ / file, image); }

 private:
  static std::vector<float> pose(const Evaluator& face, std::span<const float> controls) {
    Workspace workspace(face);
    std::vector<float> points(face.rest_positions().size());
    face.evaluate(controls.data(), points.data(), workspace);
    return points;
  }
  const Evaluator& face(const MethodReport& method) {
    std::unique_ptr<Evaluator>& kept = faces_[&method];
    if (!kept) kept = std::make_unique<Evaluator>(read_archive(method.archive).model);
    return *kept;
  }

  Source& source_;
  std::filesystem::path folder_;
  PoseRenderer renderer_;
  std::map<const MethodReport*, std::unique_ptr<Evaluator>> faces_;
};

std::string errors_text(const PoseRenderer::Comparison& comparison, const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += format("%s %s: rms %.1e, worst vertex %.1e.", i ? " " : "", names[i].c_str(), comparison.differences[i].rms,
                   comparison.differences[i].max);
  return text;
}

// Poses that are far from rest and from each other: the first has the most control, each next one the largest distance
// to those before it, with controls in units of their reach.
std::vector<FrameAddress> pick_expressive(const Source& source, const EvalReport& measured) {
  const RigSchema& schema = source.schema();
  std::vector<FrameAddress> candidates;
  std::size_t total = 0;
  for (const ClipErrors& clip : measured.clips) total += clip.errors.frames;
  const std::size_t step = std::max<std::size_t>(1, total / frames_looked_at);
  for (const ClipErrors& clip : measured.clips)
    for (std::size_t c = 0; c < source.clips().size(); ++c)
      if (source.clips()[c].name == clip.name)
        for (std::size_t f = 0; f < clip.errors.frames; f += step) candidates.push_back({c, f});
  const auto value = [&](const FrameAddress& at, std::size_t c) {
    const Control& control = schema.controls[c];
    return (source.clips()[at.clip].controls[at.frame * schema.control_count() + c] - control.rest) / control.reach();
  };
  std::vector<FrameAddress> picked;
  std::vector<double> distances;  // of candidates, squared, to the nearest picked one; to rest while there is none
  for (const FrameAddress& at : candidates) {
    double squares = 0;
    for (std::size_t c = 0; c < schema.control_count(); ++c) squares += double(value(at, c)) * value(at, c);
    distances.push_back(squares);
  }
  while (picked.size() < std::min(expressive_frames, candidates.size())) {
    const auto best =
        static_cast<std::size_t>(std::max_element(distances.begin(), distances.end()) - distances.begin());
    picked.push_back(candidates[best]);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      double squares = 0;
      for (std::size_t c = 0; c < schema.control_count(); ++c) {
        const double d = double(value(candidates[i], c)) - value(picked.back(), c);
        squares += d * d;
      }
      distances[i] = picked.size() == 1 ? squares : std::min(distances[i], squares);
    }
  }
  return picked;
}

void add_figure_1(Html& page, const ReportView& view, Studio& studio) {
  const MethodReport* linear = view.linear();
  if (!linear) return;
  const auto worst =
      std::max_element(linear->independent.clips.begin(), linear->independent.clips.end(),
                       [](const ClipErrors& a, const ClipErrors& b) { return a.errors.max < b.errors.max; });
  const FrameAddress at = studio.find(worst->name, worst->errors.worst_frame);
  const auto comparison = studio.show("figure_1.png", at, view, {&view.ours(), linear});
  page.heading("Figure 1: against linear blendshapes");
  page.picture(
      "figure_1.png",
      "The frame in which linear blendshapes are furthest off: " + studio.name(at) +
          ". From the left: the true rig, ours, linear blendshapes; then their errors as fractions of the diagonal. " +
          errors_text(comparison, {view.label(view.ours()), view.label(*linear)}));
}

void add_figure_3(Html& page, const ReportView& view, const std::vector<FrameAddress>& frames, Studio& studio,
                  Progress& progress) {
  std::vector<const MethodReport*> faces = {&view.ours()};
  if (view.backlot()) faces.push_back(view.backlot());
  std::vector<std::string> names;
  for (const MethodReport* face : faces) names.push_back(view.label(*face));
  page.heading("Figure 3: posed faces");
  page.paragraph("Measured frames that are far from rest and from each other, whatever their errors.");
  progress.begin("drawing posed faces", frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string file = format("figure_3_%zu.png", i + 1);
    const auto comparison = studio.show(file, frames[i], view, faces);
    page.picture(file, studio.name(frames[i]) + ". " + errors_text(comparison, names));
    progress.step(i + 1);
  }
}

void add_error_maps(Html& page, const ReportView& view, const Source& source, Studio& studio) {
  std::vector<Panel> panels;
  for (const MethodReport& method : view.methods()) {
    const bool shown = method.use == view.ours().use && method.independent.quality;
    if (!shown || (panels.size() + 1 == fields_shown && &method < &view.ours())) continue;
    if (panels.size() == fields_shown) break;
    const std::vector<float>& rms = method.independent.quality->vertex_rms;
    const float worst = *std::max_element(rms.begin(), rms.end()), full = round_scale(worst);
    panels.push_back({studio.renderer().draw_scalars(source.rest().points, rms, full),
                      format("%s\nworst %.1e", view.label(method).c_str(), worst), full});
  }
  if (panels.empty()) return;
  studio.write("error_map.png", make_montage(panels));
  page.heading("Error over the face");
  page.picture("error_map.png",
               "Root mean square error of each vertex over all measured frames, as a fraction of the "
               "diagonal. Each picture has a scale of its own.");
}

void add_worst_frames(Html& page, const ReportView& view, Studio& studio, Progress& progress) {
  page.heading("Worst frames of " + view.label(view.ours()));
  const std::vector<FrameOfClip> frames = worst_frames(view.ours().independent, worst_shown);
  progress.begin("drawing worst frames", frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameAddress at = studio.find(view.ours().independent.clips[frames[i].clip].name, frames[i].frame);
    const std::string file = i == 0 ? "worst.png" : format("worst_%zu.png", i + 1);
    const auto comparison = studio.show(file, at, view, {&view.ours()});
    page.picture(file, studio.name(at) + ". " + errors_text(comparison, {view.label(view.ours())}));
    progress.step(i + 1);
  }
}

}  // namespace

void add_pictures(Html& page, const ReportView& view, Source& frames, const std::filesystem::path& folder,
                  const Parallel& parallel, Progress& progress) {
  if (!view.measured()) return;
  const std::vector<FrameAddress> expressive = pick_expressive(frames, view.ours().independent);
  Studio studio(frames, expressive, folder, parallel);
  add_figure_1(page, view, studio);
  add_figure_3(page, view, expressive, studio, progress);
  add_worst_frames(page, view, studio, progress);
  add_error_maps(page, view, frames, studio);
}

}  // namespace fb::tool
