#include "commands/solve_report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "base/length_units.h"
#include "base/status.h"
#include "commands/moving_region.h"
#include "commands/pose_controls.h"
#include "render/png_file.h"
#include "render/pose_renderer.h"
#include "report/html.h"
#include "report/plot.h"
#include "solve/fit_picture.h"
#include "solve/marker_placement.h"

namespace fb::tool {
namespace {

constexpr std::size_t pictured_frames = 3, named_controls = 12, named_regions = 8;

double quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * double(values.size() - 1) + 0.5)];
}

// The region of the face that most of a point is in.
std::vector<SolveFigures::RegionFigures> regions_of(const facebaker::Model& model, const OpenedTarget& opened,
                                                    const SolvedClip& clip) {
  const std::uint32_t* const of_vertex = fb_error_vertex_regions(model.get());
  if (!of_vertex) return {};
  std::map<std::uint32_t, SolveFigures::RegionFigures> by_region;
  for (std::size_t p = 0; p < clip.point_squares.size(); ++p) {
    std::uint32_t vertex = static_cast<std::uint32_t>(p);
    if (!opened.target.face_points.empty()) {
      const SurfacePoint& point = opened.target.face_points[p];
      const auto most = std::max_element(point.weights.begin(), point.weights.end()) - point.weights.begin();
      vertex = point.vertices[static_cast<std::size_t>(most)];
    }
    SolveFigures::RegionFigures& region = by_region[of_vertex[vertex]];
    ++region.points;
    region.rms += clip.point_squares[p];
    region.max = std::max(region.max, double(clip.point_max[p]));
  }
  std::vector<SolveFigures::RegionFigures> regions;
  for (auto& [index, region] : by_region) {
    region.name = fb_error_region_name(model.get(), index);
    region.rms = std::sqrt(region.rms / double(region.points));
    regions.push_back(region);
  }
  std::stable_sort(regions.begin(), regions.end(), [](const auto& a, const auto& b) { return a.rms > b.rms; });
  return regions;
}

// The frames that are worst, no two of them near each other.
std::vector<std::size_t> worst_frames(const SolvedClip& clip) {
  std::vector<std::size_t> order(clip.frames.size()), chosen;
  for (std::size_t f = 0; f < order.size(); ++f) order[f] = f;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return clip.frames[a].max > clip.frames[b].max; });
  const std::size_t apart = order.size() / (4 * pictured_frames);
  for (const std::size_t frame : order) {
    const bool near = std::any_of(chosen.begin(), chosen.end(), [&](std::size_t other) {
      return std::max(frame, other) - std::min(frame, other) <= apart;
    });
    if (!near) chosen.push_back(frame);
    if (chosen.size() == pictured_frames) break;
  }
  return chosen;
}

// Pictures of frames: the target as far as it is a mesh, and the face.
class SolvePictures {
 public:
  SolvePictures(PoseEvaluator& evaluator, const OpenedTarget& opened, const SolvedClip& clip,
                const std::filesystem::path& folder)
      : evaluator_(evaluator), opened_(opened), clip_(clip), folder_(folder) {
    view_.region = moving_region(evaluator);
  }

  void add(Html& page, std::size_t frame) {
    const std::string file = format("frame_%zu.png", frame);
    const SolvedFrame& of = clip_.frames[frame];
    write_png(folder_ / file, draw(frame));
    page.picture(file, format("Frame %zu: %s at most, %s in the root mean square, over %u points.", frame,
                              length(of.max).c_str(), length(of.rms).c_str(), of.points));
  }
  void add_fit(Html& page) {
    if (!opened_.fit) return;
    write_png(folder_ / "fit.png", *opened_.fit);
    page.picture("fit.png", opened_.surface
                                ? "The face, coloured by how far the target is from it, and the target as it "
                                  "was laid over it."
                                : "Where the markers sit.");
  }

 private:
  std::string length(double of) const { return length_text(of, evaluator_.character().units); }

  std::vector<float> posed(std::size_t frame) {
    const std::size_t width = evaluator_.model().control_count();
    return evaluator_.positions({&clip_.controls[frame * width], width});
  }
  // Of every point of the target's own mesh.
  std::vector<float> target_points(std::size_t frame) {
    std::vector<float> raw;
    opened_.target.read(frame, raw);
    return opened_.target.to_face.applied(raw);
  }

  Image draw(std::size_t frame) {
    const std::vector<float> face = posed(frame);
    const CharacterView& character = evaluator_.character();
    const Resolution resolution = {.width = 420, .height = 520};
    std::vector<float> target;
    if (opened_.whole || opened_.surface) target = target_points(frame);
    if (opened_.whole) {
      std::vector<float> where;  // without offsets
      opened_.target.find(frame, raw_, where);
      for (std::size_t i = 0; i < opened_.target.offsets.size(); ++i) where[i] -= opened_.target.offsets[i];
      const PoseRenderer renderer(character.mesh, {face, where}, character.up_axis, view_, resolution,
                                  evaluator_.parallel());
      const ColourBar bar = {{0}, character.mesh.diagonal(), character.units};
      return renderer.draw_comparison({"target", where}, {{"solved", face}}, bar).image;
    }
    if (!opened_.surface) return draw_markers(frame, face);
    const PoseRenderer renderer(character.mesh, {face}, character.up_axis, view_, resolution, evaluator_.parallel());
    MeshView other = opened_.surface->view();
    const std::vector<float> rest = opened_.target.to_face.applied(opened_.surface->rest);
    other.points = rest;
    const PoseRenderer of_target(other, {target}, character.up_axis, {}, resolution, evaluator_.parallel());
    return make_montage(
        {{of_target.draw(target), "target", std::nullopt}, {renderer.draw(face), "solved", std::nullopt}});
  }

  // The face as solved, with its markers where they are on it, coloured by how far they should be from there.
  Image draw_markers(std::size_t frame, const std::vector<float>& face) {
    const CharacterView& character = evaluator_.character();
    MeshView posed = character.mesh;
    posed.points = face;
    std::vector<float> where;
    opened_.target.find(frame, raw_, where);
    const float* const motion = clip_.motions.empty() ? nullptr : &clip_.motions[12 * frame];
    MarkerPlacement markers;
    for (std::size_t p = 0; p < opened_.target.face_points.size(); ++p) {
      if (where[3 * p] != where[3 * p]) continue;  // not measured
      const SurfacePoint& point = opened_.target.face_points[p];
      const Vector3 at = point.at(face);
      double squares = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        const float x = at.x + opened_.target.offsets[3 * p], y = at.y + opened_.target.offsets[3 * p + 1],
                    z = at.z + opened_.target.offsets[3 * p + 2];
        const float moved = motion
                                ? motion[4 * a] * x + motion[4 * a + 1] * y + motion[4 * a + 2] * z + motion[4 * a + 3]
                                : (a == 0   ? x
                                   : a == 1 ? y
                                            : z);
        squares += double(moved - where[3 * p + a]) * (moved - where[3 * p + a]);
      }
      markers.markers.push_back({"", point, static_cast<float>(std::sqrt(squares))});
    }
    return draw_marker_fit(posed, markers,
                           {.up_axis = character.up_axis, .unit = character.units, .parallel = evaluator_.parallel()},
                           "distance from\nwhere they were captured");
  }

  PoseEvaluator& evaluator_;
  const OpenedTarget& opened_;
  const SolvedClip& clip_;
  std::filesystem::path folder_;
  View view_;
  std::vector<float> raw_;
};

void add_curves(Html& page, const SolvedClip& clip, const std::string& units) {
  const ShownUnit unit = shown_unit(units);
  Curve rms{"root mean square", {}, {}, 1}, max{"largest", {}, {}, 2};
  for (std::size_t f = 0; f < clip.frames.size(); ++f)
    for (Curve* curve : {&rms, &max}) {
      curve->x.push_back(double(f));
      curve->y.push_back((curve == &rms ? clip.frames[f].rms : clip.frames[f].max) * unit.per_unit);
    }
  page.heading("Over time");
  page.raw(draw_plot({"How far points are from the target", "frame", unit.name, {max, rms}, false, false}));
}

}  // namespace

SolveFigures::SolveFigures(const facebaker::Model& model, const OpenedTarget& opened, const SolvedClip& clip)
    : target(opened.target.what),
      units(fb_units(model.get())),
      frames(clip.frames.size()),
      points(clip.point_squares.size()),
      seconds(clip.seconds),
      regions(regions_of(model, opened, clip)),
      notes(opened.target.notes) {
  std::vector<float> largest;
  double squares = 0;
  for (std::size_t f = 0; f < frames; ++f) {
    const SolvedFrame& frame = clip.frames[f];
    squares += double(frame.rms) * frame.rms * frame.points;
    measured += frame.points;
    iterations += frame.iterations;
    largest.push_back(frame.max);
    if (frame.max > max) worst_frame = f;
    max = std::max(max, double(frame.max));
  }
  if (measured > 0) rms = std::sqrt(squares / double(measured));
  p99 = quantile(largest, 0.99);
  iterations /= double(frames);
  const std::vector<fb_control> controls = controls_of(model);
  for (std::size_t c = 0; c < controls.size(); ++c) {
    double moved = 0;
    for (std::size_t f = 0; f < frames; ++f)
      moved = std::max(moved, std::fabs(double(clip.controls[f * controls.size() + c]) - controls[c].rest));
    moved /= double(controls[c].maximum) - controls[c].minimum;
    if (moved < 0.01) continue;
    ++moving;
    if (clip.decided[c] < 0.5f) undecided.push_back({controls[c].name, clip.decided[c], moved});
  }
  std::stable_sort(undecided.begin(), undecided.end(), [](const auto& a, const auto& b) { return a.moved > b.moved; });
}

std::string SolveFigures::text() const {
  const auto length = [&](double of) { return length_text(of, units); };
  std::string text = format(
      "%zu frames of %zu points: %s off in the root mean square, %s in the worst frame's worst point (frame %zu), %s "
      "in "
      "99 of 100 frames\n",
      frames, points, length(rms).c_str(), length(max).c_str(), worst_frame, length(p99).c_str());
  text += format("%zu controls move; the target decides %zu of them by less than half", moving, undecided.size());
  for (std::size_t i = 0; i < std::min(undecided.size(), named_controls); ++i)
    text += (i == 0 ? ": " : ", ") + undecided[i].control;
  text += undecided.size() > named_controls ? format(" and %zu more\n", undecided.size() - named_controls) : "\n";
  text += format("%.1f ms and %.1f iterations a frame\n", 1e3 * seconds / double(frames), iterations);
  return text;
}

std::string SolveFigures::json() const {
  nlohmann::ordered_json document = {{"target", target},
                                     {"frames", frames},
                                     {"points", points},
                                     {"units", units},
                                     {"rms", rms},
                                     {"max", max},
                                     {"p99fm", p99},
                                     {"worst_frame", worst_frame},
                                     {"controls_moving", moving},
                                     {"seconds", seconds},
                                     {"iterations", iterations}};
  auto& of_regions = document["regions"] = nlohmann::ordered_json::array();
  for (const RegionFigures& region : regions)
    of_regions.push_back({{"name", region.name}, {"points", region.points}, {"rms", region.rms}, {"max", region.max}});
  auto& of_controls = document["undecided"] = nlohmann::ordered_json::array();
  for (const Undecided& one : undecided)
    of_controls.push_back({{"control", one.control}, {"decided", one.decided}, {"moved", one.moved}});
  document["notes"] = notes;
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void write_solve_report(const std::filesystem::path& folder, const SolveFigures& figures, PoseEvaluator& evaluator,
                        const OpenedTarget& opened, const SolvedClip& clip, Progress& progress) {
  Html page(evaluator.character().name + ": solved for " + figures.target);
  const auto length = [&](double of) { return length_text(of, figures.units); };
  page.lead(format("%zu frames: %s off in the root mean square, %s at most.", figures.frames,
                   length(figures.rms).c_str(), length(figures.max).c_str()));
  page.preformatted(figures.text());
  if (!figures.notes.empty()) page.list(figures.notes);
  SolvePictures pictures(evaluator, opened, clip, folder);
  if (opened.fit) {
    page.heading("How the target fits the face");
    page.paragraph(opened.fit_text);
    pictures.add_fit(page);
  }
  add_curves(page, clip, figures.units);
  page.heading("Worst frames");
  const std::vector<std::size_t> frames = worst_frames(clip);
  progress.begin(Phase::writing, "drawing frames", frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    pictures.add(page, frames[i]);
    progress.step(i + 1);
  }
  if (!figures.regions.empty()) {
    page.heading("By region");
    std::vector<std::vector<std::string>> rows = {{"region", "points", "root mean square", "largest"}};
    for (std::size_t r = 0; r < std::min(figures.regions.size(), named_regions); ++r)
      rows.push_back({figures.regions[r].name, std::to_string(figures.regions[r].points),
                      length(figures.regions[r].rms), length(figures.regions[r].max)});
    page.table(rows);
  }
  if (!figures.undecided.empty()) {
    page.heading("Controls that the target does not decide");
    page.paragraph("Others do as well for these points: what they are comes from the wish for little and few motion.");
    std::vector<std::vector<std::string>> rows = {{"control", "decided", "moves by"}};
    for (std::size_t i = 0; i < std::min(figures.undecided.size(), 2 * named_controls); ++i)
      rows.push_back({figures.undecided[i].control, format("%.0f %%", 100 * figures.undecided[i].decided),
                      format("%.0f %% of its range", 100 * figures.undecided[i].moved)});
    page.table(rows);
  }
  page.explain();
  write_file(folder / "index.html", page.page());
}

}  // namespace fb::tool
