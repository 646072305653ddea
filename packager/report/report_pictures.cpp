// The sections of pictures: the paper's Figures 1 and 3, the worst frames, and errors over the face.
#include <algorithm>
#include <span>

#include "base/status.h"
#include "render/montage.h"
#include "report/report_pictures.h"

namespace fb::tool {
namespace {

constexpr std::size_t expressive_frames = 4, candidate_frames = 1000, worst_shown = 4, error_maps_shown = 4;

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

std::vector<PosedFrame> read_all(FrameReader& reader, const std::vector<FrameAddress>& frames,
                                 const std::vector<const MethodReport*>& methods) {
  std::vector<PosedFrame> read;
  for (const FrameAddress& at : frames) read.push_back(reader.read(at, methods));
  return read;
}

// The frame in which linear blendshapes are furthest off, if there are any.
std::vector<PosedFrame> read_figure_1(FrameReader& reader, const ReportView& view) {
  const MethodReport* linear = view.linear();
  if (!linear) return {};
  const auto worst =
      std::max_element(linear->independent.clips.begin(), linear->independent.clips.end(),
                       [](const ClipErrors& a, const ClipErrors& b) { return a.errors.max < b.errors.max; });
  return {reader.read(reader.find(worst->name, worst->errors.worst_frame), {&view.ours(), linear})};
}

std::vector<FrameAddress> worst_frames_of(const FrameReader& reader, const MethodReport& method) {
  std::vector<FrameAddress> worst;
  for (const FrameOfClip& at : method.independent.worst)
    if (worst.size() < worst_shown) worst.push_back(reader.find(method.independent.clips.at(at.clip).name, at.frame));
  return worst;
}

// The frame in which touching surfaces are furthest off, if that is seen.
std::vector<PosedFrame> read_contact(FrameReader& reader, const ReportView& view) {
  if (!view.ours().independent.quality) return {};
  const ContactErrors& contact = view.ours().independent.quality->contact;
  if (contact.max <= contact.visible) return {};
  return {reader.read(reader.find(contact.worst_clip, contact.worst_frame), {&view.ours()})};
}

// The methods whose errors over the face are shown: of the use of ours, which is among them.
std::vector<const MethodReport*> mapped_methods(const ReportView& view) {
  std::vector<const MethodReport*> mapped;
  for (const MethodReport& method : view.methods()) {
    if (method.use != view.ours().use || !method.independent.quality) continue;
    if (mapped.size() + 1 == error_maps_shown && &method < &view.ours()) continue;  // the last one is kept for ours
    if (mapped.size() < error_maps_shown) mapped.push_back(&method);
  }
  return mapped;
}

float largest_rms(const MethodReport& method) {
  const std::vector<float>& rms = method.independent.quality->vertex_rms;
  return *std::max_element(rms.begin(), rms.end());
}

void add_scale(Html& page, const FramePictures& pictures) {
  const ColourBar& bar = pictures.bar();
  page.paragraph(format(
      "Colours mean the same in all pictures of errors on this page, for every method: logarithmic from %.2g D and "
      "less, "
      "pale (%.2g %s), to %.2g D, dark (%.2g %s). A ring is round the worst vertex, which may lie behind what is seen.",
      bar.scale.ticks().front(), bar.scale.ticks().front() * bar.length, bar.units.c_str(), bar.scale.end,
      bar.scale.end * bar.length, bar.units.c_str()));
  if (pictures.part_of_body())
    page.paragraph("What moves is a small part of the mesh: pictures show that part and its surroundings.");
}

void add_figure_1(Html& page, const std::vector<PosedFrame>& frames, const FramePictures& pictures) {
  for (const PosedFrame& frame : frames) {
    const std::string errors = pictures.write_comparison("figure_1.png", frame);
    page.folded_heading("Figure 1: against linear blendshapes");
    page.picture("figure_1.png", "The frame in which linear blendshapes are furthest off: " + frame.name +
                                     ". From the left: the true rig, ours, linear blendshapes; then their errors. " +
                                     errors);
  }
}

void add_frame(Html& page, const PosedFrame& frame, const FramePictures& pictures, const std::string& file) {
  const std::string errors = pictures.write_comparison(file, frame);
  page.picture(file, frame.name + ". " + errors);
}

// Pictures of frames with their captions: name_FIRST.png and so on.
void add_frames(Html& page, std::span<const PosedFrame> frames, const FramePictures& pictures, const std::string& name,
                std::size_t first, Progress& progress, const char* stage) {
  progress.begin(Phase::writing, stage, frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    add_frame(page, frames[i], pictures, format("%s_%zu.png", name.c_str(), first + i));
    progress.step(i + 1);
  }
}

void add_error_maps(Html& page, const ReportView& view, const FramePictures& pictures) {
  std::vector<Panel> panels;
  for (const MethodReport* method : mapped_methods(view))
    panels.push_back({pictures.draw_rest(method->independent.quality->vertex_rms),
                      format("%s\nworst %.1e", view.label(*method).c_str(), largest_rms(*method)),
                      {}});
  if (panels.empty()) return;
  panels.back().bar = pictures.bar();
  pictures.write("error_map.png", make_montage(panels));
  page.folded_heading("Error over the face");
  page.picture("error_map.png",
               "Root mean square error of each vertex over all measured frames, as a fraction of the diagonal, in the "
               "colours of all pictures of this page.");
}

}  // namespace

ReportPictures::ReportPictures(const ReportView& view, const facebaker::SourceView& source,
                               const std::filesystem::path& folder, const Parallel& parallel, Progress& progress)
    : view_(view), progress_(progress) {
  if (!view.measured()) return;
  FrameReader reader(source);
  std::vector<const MethodReport*> faces = {&view.ours()};
  if (view.backlot()) faces.push_back(view.backlot());
  figure_1_ = read_figure_1(reader, view);
  expressive_ = read_all(reader, pick_expressive(source, view.ours().independent.clips), faces);
  worst_ = read_all(reader, worst_frames_of(reader, view.ours()), {&view.ours()});
  contact_ = read_contact(reader, view);
  std::vector<PosedFrame> all;
  for (const std::vector<PosedFrame>* frames : {&figure_1_, &contact_, &expressive_, &worst_})
    all.insert(all.end(), frames->begin(), frames->end());
  float largest = 0;
  for (const MethodReport* method : mapped_methods(view)) largest = std::max(largest, largest_rms(*method));
  pictures_.emplace(view, source, all, largest, folder, parallel);
}

void ReportPictures::add_worst(Html& page) const {
  if (!worst_.empty()) add_frame(page, worst_.front(), *pictures_, "worst.png");
}

void ReportPictures::add_sections(Html& page) const {
  if (!pictures_) return;
  add_parts(page, view_, *pictures_);
  page.folded_heading("Worst frames of " + view_.label(view_.ours()));
  page.paragraph(
      "The frames with the largest error of a vertex that differ from each other, behind the first, which is above: at "
      "least 12 frames apart, and poses further apart than half the way from rest to the farther one. First those "
      "whose "
      "worst vertices lie at least 5 % of the diagonal apart.");
  add_scale(page, *pictures_);
  add_frames(page, std::span(worst_).subspan(std::min<std::size_t>(1, worst_.size())), *pictures_, "worst", 2,
             progress_, "drawing worst frames");
  if (!contact_.empty()) {
    page.subheading("Worst contact");
    page.paragraph(contact_text(view_.ours().independent.quality->contact));
    add_frame(page, contact_.front(), *pictures_, "contact.png");
  }
  add_error_maps(page, view_, *pictures_);
  add_figure_1(page, figure_1_, *pictures_);
  page.folded_heading("Figure 3: posed faces");
  page.paragraph("Measured frames that are far from rest and from each other, whatever their errors.");
  add_frames(page, expressive_, *pictures_, "figure_3", 1, progress_, "drawing posed faces");
}

}  // namespace fb::tool
