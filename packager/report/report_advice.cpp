// The section that says what to do about the figures.
#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "report/report_view.h"

namespace fb::tool {
namespace {

// Beyond these, something is worth a sentence.
constexpr double weak_share = 0.3;      // of the squared error, in one region
constexpr double leaking_share = 0.05;  // of the controls
constexpr double seam_ratio = 1.5;

void add_weakest_region(std::vector<std::string>& items, const Quality& quality) {
  const auto error = [](const RegionErrors& region) { return region.mse * static_cast<double>(region.vertices); };
  double all = 0;
  for (const RegionErrors& region : quality.regions) all += error(region);
  const auto worst = std::max_element(quality.regions.begin(), quality.regions.end(),
                                      [&](const auto& a, const auto& b) { return error(a) < error(b); });
  if (quality.regions.size() < 2 || !(all > 0) || error(*worst) < weak_share * all) return;
  items.push_back(
      format("%.0f %% of the squared error of all regions lies in \"%s\", in %llu vertices: poses of the "
             "controls that move it (%s) would help most.",
             100 * error(*worst) / all, worst->title.c_str(), static_cast<unsigned long long>(worst->vertices),
             worst->movers.empty() ? "none alone"
                                   : (worst->movers[0] + (worst->movers.size() > 1 ? " and others" : "")).c_str()));
}

void add_hardest_control(std::vector<std::string>& items, const Quality& quality) {
  const ControlQuality* hardest = nullptr;
  for (const ControlQuality& control : quality.controls)
    if (control.combined.frames > 0 && (!hardest || control.combined.mse > hardest->combined.mse)) hardest = &control;
  if (hardest)
    items.push_back(
        format("The hardest control in combination is \"%s\": rms %.1e, worst %.1e of the diagonal on what "
               "it moves, in %llu frames.",
               hardest->name.c_str(), std::sqrt(hardest->combined.mse), hardest->combined.max,
               static_cast<unsigned long long>(hardest->combined.frames)));
}

void add_leaks(std::vector<std::string>& items, const Locality& locality) {
  if (locality.above <= leaking_share || locality.leaks.empty()) return;
  items.push_back(format(
      "%.0f %% of the controls move vertices that they leave alone in the rig by more than %.0e of the "
      "diagonal, most of all \"%s\" by %.1e: only worth a look if it is seen.",
      100 * locality.above, locality.options.tolerance, locality.leaks[0].control.c_str(), locality.leaks[0].leak));
}

void add_contact(std::vector<std::string>& items, const ContactErrors& contact) {
  if (contact.max > contact.visible)
    items.push_back(
        "What touches in the rig is seen apart or in each other in the face; more poses that close it would help. " +
        contact_text(contact));
}

}  // namespace

bool is_advice(const std::string& note) {
  return note.starts_with("warning: ") || note.starts_with("overfitting: ");
}

void add_advice(Html& page, const ReportView& view) {
  std::vector<std::string> items;
  const MethodReport& ours = view.ours();
  for (const std::string& note : ours.stats.notes)
    if (is_advice(note)) items.push_back(note + ".");
  if (view.measured() && ours.independent.quality) {
    add_weakest_region(items, *ours.independent.quality);
    add_hardest_control(items, *ours.independent.quality);
    add_contact(items, ours.independent.quality->contact);
    const Quality& q = *ours.independent.quality;
    if (q.border_edges > 0 && q.border_jump > seam_ratio * q.inside_jump)
      items.push_back(
          format("The error jumps %.1f times as far where regions meet as inside them: look for seams there.",
                 q.border_jump / q.inside_jump));
  }
  if (ours.locality) add_leaks(items, *ours.locality);
  if (items.empty()) return;
  page.heading("What to do");
  page.list(items);
}

}  // namespace fb::tool
