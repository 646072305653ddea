// The sections of curves and bars: errors over time, by region and by control, training and learning.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/status.h"
#include "report/plot.h"
#include "report/report_view.h"

namespace fb::tool {
namespace {

constexpr std::size_t clips_shown = 8, controls_shown = 24;

std::vector<double> numbers_to(std::size_t count, double from = 0) {
  std::vector<double> numbers(count);
  std::iota(numbers.begin(), numbers.end(), from);
  return numbers;
}

// One figure of every frame of a clip, a curve for every method.
Plot plot_over_time(const ReportView& view, std::size_t clip, const char* label,
                    std::vector<double> ClipErrors::*figure) {
  Plot plot{view.ours().clips[clip].name, "frame", label, {}};
  for (const MethodFigures& method : view.methods()) {
    const std::vector<double>& frames = method.clips.at(clip).*figure;
    plot.curves.push_back(
        {view.label(method), numbers_to(frames.size()), frames, view.colour(method), method.use == "backlot"});
  }
  return plot;
}

// Mean squared error of every method in the regions of ours.
void add_regions(Html& page, const ReportView& view) {
  const Quality& ours = *view.ours().quality;
  if (ours.regions.size() < 2) return;
  page.subheading("By region");
  page.paragraph(
      "Regions are those of " + view.label(view.ours()) +
      "; a vertex belongs to the region that moves it most. Mean squared error / D^2, on a logarithmic scale.");
  std::vector<std::string> names;
  std::vector<int> colours;
  std::vector<Bar> bars;
  for (const std::string& region : ours.region_names) bars.push_back({region, {}});
  for (const MethodFigures& method : view.methods()) {
    if (method.use != view.ours().use || !method.quality) continue;
    names.push_back(view.label(method));
    colours.push_back(view.colour(method));
    const std::vector<float>& rms = method.quality->vertex_rms;
    std::vector<double> squares(bars.size()), counts(bars.size());
    for (std::size_t v = 0; v < rms.size(); ++v)
      if (const std::size_t label = ours.vertex_region[v]; label < bars.size()) {
        squares[label] += double(rms[v]) * rms[v];
        ++counts[label];
      }
    for (std::size_t r = 0; r < bars.size(); ++r)
      bars[r].values.push_back(counts[r] > 0 ? squares[r] / counts[r] : NAN);
  }
  std::erase_if(bars, [](const Bar& bar) { return !std::isfinite(bar.values[0]); });
  page.raw(draw_bars(names, colours, bars, true));
}

void add_controls(Html& page, const ReportView& view) {
  std::vector<PartErrors> worst = view.ours().quality->controls;
  if (worst.empty()) return;
  std::stable_sort(worst.begin(), worst.end(), [](const auto& a, const auto& b) { return a.mse > b.mse; });
  const std::size_t all = worst.size();
  worst.resize(std::min(all, controls_shown));
  page.subheading("By control");
  page.paragraph(
      format("Mean squared error / D^2 of the frames in which a control is beyond half of its range: the worst %zu of "
             "%zu controls that are.",
             worst.size(), all));
  std::vector<std::string> names = {view.label(view.ours())};
  std::vector<int> colours = {view.colour(view.ours())};
  const MethodFigures* linear = view.linear();
  if (linear && linear->quality) {
    names.push_back(view.label(*linear));
    colours.push_back(view.colour(*linear));
  }
  std::vector<Bar> bars;
  for (const PartErrors& control : worst) {
    bars.push_back({control.name, {control.mse}});
    if (names.size() < 2) continue;
    for (const PartErrors& other : linear->quality->controls)
      if (other.name == control.name) bars.back().values.push_back(other.mse);
  }
  page.raw(draw_bars(names, colours, bars, names.size() > 1));
}

void add_training_curves(Html& page, const BakeStats& stats) {
  Plot plot{"Squared coefficient error over squared coefficients", "epoch", "", {}};
  for (std::size_t r = 0; r < stats.networks.size(); ++r) {
    const NetworkStats& network = stats.networks[r];
    const std::vector<double> epochs = numbers_to(network.training_loss.size(), 1);
    const int colour = static_cast<int>(r) + 1;
    Curve training{"", epochs, network.training_loss, colour, true},
        validation{network.name, epochs, network.validation_loss, colour};
    const bool validated = std::any_of(validation.y.begin(), validation.y.end(), [](double y) { return y > 0; });
    if (!validated) training.name = network.name;
    plot.curves.push_back(std::move(training));
    if (validated) plot.curves.push_back(std::move(validation));
  }
  plot.width = 900;
  plot.height = 380;
  const std::string svg = draw_plot(plot);
  if (svg.empty()) return;
  page.subheading("Training curve");
  page.paragraph("Dotted: training poses. Solid: validation poses.");
  page.raw(svg);
}

void add_network_table(Html& page, const BakeStats& stats) {
  if (stats.networks.empty()) return;
  page.subheading("Networks");
  std::vector<std::vector<std::string>> rows = {{"region", "vertices", "inputs", "coefficients", "numbers",
                                                 "share of the energy", "validation error", "restarts"}};
  for (const NetworkStats& r : stats.networks)
    rows.push_back({r.name, std::to_string(r.vertices), std::to_string(r.inputs), std::to_string(r.coefficients),
                    std::to_string(r.parameters), format("%.1f %%", 100 * r.energy),
                    r.validation > 0 ? figure_text(r.validation) : "-", std::to_string(r.restarts)});
  page.table(rows);
}

}  // namespace

void add_errors_over_time(Html& page, const ReportView& view) {
  if (!view.measured() || !view.ours().quality) return;
  const auto& clips = view.ours().clips;
  std::vector<std::size_t> shown(clips.size());
  std::iota(shown.begin(), shown.end(), std::size_t{0});
  std::erase_if(shown, [&](std::size_t c) { return clips[c].frame_max.size() < 2; });
  // Shots first: their frames follow each other in time.
  std::stable_partition(shown.begin(), shown.end(), [&](std::size_t c) { return clips[c].kind == "shot"; });
  if (shown.empty()) return;
  page.heading("Error over time");
  const std::size_t all = shown.size();
  shown.resize(std::min(all, clips_shown));
  if (all > shown.size()) page.paragraph(format("The first %zu of %zu clips, shots first.", shown.size(), all));
  for (const std::size_t c : shown) {
    page.raw("<div class=\"plots\">\n");
    page.raw(draw_plot(plot_over_time(view, c, "worst vertex / D", &ClipErrors::frame_max)));
    page.raw(draw_plot(plot_over_time(view, c, "mean squared error / D^2", &ClipErrors::frame_mse)));
    page.raw("</div>\n");
  }
}

void add_parts(Html& page, const ReportView& view) {
  if (!view.measured() || !view.ours().quality) return;
  page.heading("Error by region and by control");
  add_regions(page, view);
  add_controls(page, view);
}

void add_training(Html& page, const ReportView& view) {
  const BakeStats& stats = view.ours().stats;
  const bool curves =
      std::any_of(stats.networks.begin(), stats.networks.end(), [](const auto& r) { return !r.training_loss.empty(); });
  if (!curves && stats.networks.empty() && stats.learning.empty() && stats.coverage.empty() && stats.stages.empty())
    return;
  page.heading("Training of " + view.label(view.ours()));
  add_training_curves(page, stats);
  add_network_table(page, stats);
  if (!stats.learning.empty()) {
    page.subheading("Learning curve");
    page.paragraph("Errors on validation poses, by the number of training poses.");
    Plot plot{"Error by the number of poses", "poses", "", {}, true, true};
    Curve mse{"mean squared error / D^2", {}, {}, 1}, max{"worst vertex / D", {}, {}, 2};
    for (const LearningPoint& point : stats.learning) {
      mse.x.push_back(point.poses);
      max.x.push_back(point.poses);
      mse.y.push_back(point.mse);
      max.y.push_back(point.max);
    }
    plot.curves = {mse, max};
    page.raw(draw_plot(plot));
  }
  if (!stats.coverage.empty()) {
    page.subheading("Coverage");
    page.preformatted(stats.coverage);
  }
  if (!stats.stages.empty()) {
    page.subheading("Time");
    std::vector<std::vector<std::string>> rows = {{"stage", "seconds"}};
    for (const StageTime& stage : stats.stages) rows.push_back({stage.name, format("%.1f", stage.seconds)});
    page.table(rows);
  }
}

}  // namespace fb::tool
