// The sections of errors by region and by control.
#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "report/frame_pictures.h"
#include "report/plot.h"
#include "report/report_view.h"

namespace fb::tool {
namespace {

using Rows = std::vector<std::vector<std::string>>;

constexpr std::size_t controls_shown = 24;

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "-" : text;
}

std::string css_colour(std::size_t part) {
  const Rgb colour = part_colour(part);
  return format("#%02x%02x%02x", colour.r, colour.g, colour.b);
}

// By vertex: an index into the regions that have vertices, or their number.
std::vector<std::size_t> parts_of(const Quality& quality) {
  std::vector<std::size_t> of_name(quality.region_names.size() + 1, quality.regions.size());
  for (std::size_t n = 0; n < quality.region_names.size(); ++n)
    for (std::size_t r = 0; r < quality.regions.size(); ++r)
      if (quality.regions[r].name == quality.region_names[n]) of_name[n] = r;
  std::vector<std::size_t> parts;
  for (const std::size_t region : quality.vertex_region) parts.push_back(of_name[region]);
  return parts;
}

// The errors of all methods in the regions of ours.
void add_region_bars(Html& page, const ReportView& view, const std::vector<std::size_t>& parts) {
  const Quality& ours = *view.ours().independent.quality;
  std::vector<std::string> names;
  std::vector<int> colours;
  std::vector<Bar> bars;
  for (const RegionErrors& region : ours.regions) bars.push_back({region.title, {}});
  for (const MethodReport& method : view.methods()) {
    if (method.use != view.ours().use || !method.independent.quality) continue;
    names.push_back(view.label(method));
    colours.push_back(view.colour(method));
    const std::vector<float>& rms = method.independent.quality->vertex_rms;
    std::vector<double> squares(bars.size()), counts(bars.size());
    for (std::size_t v = 0; v < rms.size(); ++v)
      if (parts[v] < bars.size()) {
        squares[parts[v]] += double(rms[v]) * rms[v];
        ++counts[parts[v]];
      }
    for (std::size_t r = 0; r < bars.size(); ++r) bars[r].values.push_back(std::sqrt(squares[r] / counts[r]));
  }
  page.paragraph("Root mean square error / D of all methods in these regions, on a logarithmic scale.");
  page.raw(draw_bars(names, colours, bars, true));
}

void add_regions(Html& page, const ReportView& view, const FramePictures& pictures) {
  const Quality& ours = *view.ours().independent.quality;
  if (ours.regions.size() < 2) return;
  page.subheading("By region");
  page.paragraph("Regions are those of the networks of " + view.label(view.ours()) +
                 "; a vertex belongs to the region that moves it most. They are named by the control group that moves "
                 "them, and by where they lie in the face or among the regions of that group; left and right are the "
                 "face's own.");
  const std::vector<std::size_t> parts = parts_of(ours);
  pictures.write("regions.png", pictures.draw_parts(parts, ours.regions.size()));
  page.picture("regions.png",
               "The regions at rest, numbered and coloured as in the table below; those without a number are hidden. "
               "Grey moves without networks, by blendshapes alone, or not at all.");
  double all = 0;
  for (const RegionErrors& region : ours.regions) all += region.mse * static_cast<double>(region.vertices);
  Rows rows = {{"region", "moved by", "vertices", "worst / D", "p99fm", "mfm", "rms / D", "share of error"}};
  std::vector<std::string> colours;
  for (std::size_t r = 0; r < ours.regions.size(); ++r) {
    const RegionErrors& region = ours.regions[r];
    const double share = all > 0 ? region.mse * static_cast<double>(region.vertices) / all : 0;
    rows.push_back({format("%zu. %s", r + 1, region.title.c_str()), joined(region.movers),
                    std::to_string(region.vertices), view.length(region.max), view.length(region.p99fm),
                    view.length(region.mfm), view.length(std::sqrt(region.mse)), format("%.1f %%", 100 * share)});
    colours.push_back(css_colour(r));
  }
  page.table(rows, colours);
  add_region_bars(page, view, parts);
}

std::vector<std::string> alone_cells(const ReportView& view, const std::string& control) {
  const MethodReport& method = view.ours();
  if (method.locality)
    for (const ControlLeak& alone : method.locality->leaks)
      if (alone.control == control)
        return {format("%zu (%zu)", alone.alone_poses, alone.unseen_poses), view.length(alone.alone_error)};
  return {"0", "-"};
}

void add_controls(Html& page, const ReportView& view) {
  const MethodReport& ours = view.ours();
  std::vector<ControlQuality> worst = ours.independent.quality->controls;
  if (worst.empty()) return;
  const auto combined = [](const ControlQuality& control) {
    return control.combined.frames > 0 ? control.combined.mse : 0;
  };
  std::stable_sort(worst.begin(), worst.end(), [&](const auto& a, const auto& b) { return combined(a) > combined(b); });
  const std::size_t all = worst.size();
  worst.resize(std::min(all, controls_shown));
  const bool linear = view.linear() && view.linear()->independent.quality;
  page.subheading("By control");
  page.paragraph(format(
      "Measured where each control acts. In combination: on the vertices that the control moves, in the measured "
      "frames "
      "in which it is beyond half its reach and another control is off rest. Alone: on the whole face, in poses in "
      "which all others are at rest (%s). The worst %zu of %zu controls that go so far in the measured clips.",
      !ours.locality                      ? "there are none"
      : ours.locality->recorded_poses > 0 ? "recorded; in brackets, those that were not trained on"
                                          : "both ends of its range, on the live rig",
      worst.size(), all));
  Rows rows = {{"control", "vertices moved", "combined: frames", "combined: rms / D", "combined: worst / D",
                "alone: poses", "alone: worst / D"}};
  if (linear) rows[0].push_back("linear, combined: rms / D");
  for (const ControlQuality& control : worst) {
    const FrameSetErrors& errors = control.combined;
    const bool seen = errors.frames > 0;
    rows.push_back({control.name, std::to_string(control.vertices), std::to_string(errors.frames),
                    seen ? view.length(std::sqrt(errors.mse)) : "-", seen ? view.length(errors.max) : "-"});
    for (std::string& cell : alone_cells(view, control.name)) rows.back().push_back(std::move(cell));
    if (!linear) continue;
    std::string beside = "-";
    for (const ControlQuality& other : view.linear()->independent.quality->controls)
      if (other.name == control.name && other.combined.frames > 0) beside = view.length(std::sqrt(other.combined.mse));
    rows.back().push_back(beside);
  }
  page.table(rows);
}

}  // namespace

void add_parts(Html& page, const ReportView& view, const FramePictures& pictures) {
  if (!view.ours().independent.quality) return;
  page.folded_heading("Error by region and by control");
  add_regions(page, view, pictures);
  add_controls(page, view);
}

}  // namespace fb::tool
