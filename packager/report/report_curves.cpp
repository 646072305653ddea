// The sections of curves and bars: errors over time, training and learning.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/status.h"
#include "report/plot.h"
#include "report/report_view.h"

namespace fb::tool {
namespace {

constexpr std::size_t clips_shown = 8;

std::vector<double> numbers_to(std::size_t count, double from = 0) {
  std::vector<double> numbers(count);
  std::iota(numbers.begin(), numbers.end(), from);
  return numbers;
}

// One figure of every frame of a clip, a curve for every method.
Plot plot_over_time(const ReportView& view, std::size_t clip, const char* label, float FrameErrors::*figure) {
  Plot plot{view.ours().independent.clips[clip].name, "frame", label, {}};
  for (const MethodReport& method : view.methods()) {
    std::vector<double> frames;
    for (const FrameErrors& frame : method.independent.clips.at(clip).frames) frames.push_back(frame.*figure);
    plot.curves.push_back(
        {view.label(method), numbers_to(frames.size()), frames, view.colour(method), method.use == "backlot"});
  }
  return plot;
}

void add_training_curves(Html& page, const BakeStats& stats) {
  Plot plot{"Squared coefficient error over squared coefficients", "epoch", "", {}};
  for (std::size_t r = 0; r < stats.regions.size(); ++r) {
    const RegionStats& network = stats.regions[r];
    const std::vector<double> epochs = numbers_to(network.epochs.size(), 1);
    const int colour = static_cast<int>(r) + 1;
    Curve training{"", epochs, {}, colour, true}, validation{network.name, epochs, {}, colour};
    for (const EpochLoss& epoch : network.epochs) {
      training.y.push_back(epoch.training);
      validation.y.push_back(epoch.validation);
    }
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
  if (stats.regions.empty()) return;
  page.subheading("Networks");
  std::vector<std::vector<std::string>> rows = {{"region", "vertices", "inputs", "coefficients", "numbers", "poses",
                                                 "share of the energy", "left of training", "validation error",
                                                 "restarts"}};
  for (const RegionStats& r : stats.regions)
    rows.push_back({r.name, std::to_string(r.vertices), std::to_string(r.inputs), std::to_string(r.coefficients),
                    std::to_string(r.parameters), std::to_string(r.poses), format("%.1f %%", 100 * r.energy),
                    r.epochs.empty() ? "-" : figure_text(r.epochs.back().training),
                    r.validation > 0 ? figure_text(r.validation) : "-", std::to_string(r.restarts)});
  page.table(rows);
}

}  // namespace

void add_errors_over_time(Html& page, const ReportView& view) {
  if (!view.measured() || !view.ours().independent.quality) return;
  const auto& clips = view.ours().independent.clips;
  std::vector<std::size_t> shown(clips.size());
  std::iota(shown.begin(), shown.end(), std::size_t{0});
  std::erase_if(shown, [&](std::size_t c) { return clips[c].frames.size() < 2; });
  // Shots first: their frames follow each other in time.
  std::stable_partition(shown.begin(), shown.end(), [&](std::size_t c) { return clips[c].kind == "shot"; });
  if (shown.empty()) return;
  page.folded_heading("Error over time");
  const std::size_t all = shown.size();
  shown.resize(std::min(all, clips_shown));
  if (all > shown.size()) page.paragraph(format("The first %zu of %zu clips, shots first.", shown.size(), all));
  for (const std::size_t c : shown) {
    page.raw("<div class=\"plots\">\n");
    page.raw(draw_plot(plot_over_time(view, c, "worst vertex / D", &FrameErrors::max)));
    page.raw(draw_plot(plot_over_time(view, c, "mean squared error / D^2", &FrameErrors::mse)));
    page.raw("</div>\n");
  }
}

void add_training(Html& page, const ReportView& view) {
  const BakeStats& stats = view.ours().stats;
  const bool curves =
      std::any_of(stats.regions.begin(), stats.regions.end(), [](const auto& r) { return !r.epochs.empty(); });
  if (!curves && stats.regions.empty() && stats.learning.empty() && stats.coverage.empty()) return;
  page.folded_heading("Training of " + view.label(view.ours()));
  add_training_curves(page, stats);
  add_network_table(page, stats);
  if (!stats.learning.empty()) {
    page.subheading("Learning curve");
    page.paragraph("Errors on validation poses, by the number of training poses.");
    Plot plot{"Error by the number of poses", "poses", "", {}, true, true};
    Curve mse{"mean squared error / D^2", {}, {}, 1}, max{"worst vertex / D", {}, {}, 2};
    for (const LearningPoint& point : stats.learning) {
      mse.x.push_back(static_cast<double>(point.poses));
      max.x.push_back(static_cast<double>(point.poses));
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
}

}  // namespace fb::tool
