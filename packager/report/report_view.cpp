#include "report/report_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/length_units.h"
#include "base/status.h"

namespace fb::tool {
namespace {

// Recipes in the order of preference for the pictures, the best last; any other recipe ranks as 1.
constexpr std::array<const char*, 4> by_preference = {"linear", "paper", "compact", "hero"};

std::size_t rank(const std::string& name) {
  const auto at = std::find(by_preference.begin(), by_preference.end(), name);
  if (name == "linear") return 0;
  return at == by_preference.end() ? 1 : 1 + static_cast<std::size_t>(at - by_preference.begin());
}

}  // namespace

ReportView::ReportView(const FaceFigures& figures) : figures_(&figures) {
  const auto& all = methods();
  for (std::size_t m = 1; m < all.size(); ++m) {
    const std::size_t candidate = rank(all[m].name), best = rank(all[ours_].name);
    if (candidate > best ||
        (candidate == best && all[m].name == all[ours_].name && all[m].use == "variant" && all[ours_].use == "backlot"))
      ours_ = m;
  }
  for (std::size_t m = 0; m < all.size(); ++m) {
    if (m != ours_ && all[m].name == ours().name && all[m].use != ours().use) backlot_ = m;
    if (m != ours_ && all[m].name == "linear" && all[m].use == ours().use) linear_ = m;
    if (all[m].name != "linear" && std::find(recipes_.begin(), recipes_.end(), all[m].name) == recipes_.end())
      recipes_.push_back(all[m].name);
  }
}

std::string ReportView::label(const MethodReport& method) const {
  const auto other_use = [&](const MethodReport& other) { return other.use != method.use; };
  const bool both = std::any_of(methods().begin(), methods().end(), other_use);
  return both ? method.name + " " + method.use : method.name;
}

int ReportView::colour(const MethodReport& method) const {
  const auto at = std::find(recipes_.begin(), recipes_.end(), method.name);
  if (at == recipes_.end()) return 0;
  if (method.name == ours().name) return 1;
  const auto own = std::find(recipes_.begin(), recipes_.end(), ours().name);
  return at < own ? 2 + static_cast<int>(at - recipes_.begin()) : 1 + static_cast<int>(at - recipes_.begin());
}

std::string ReportView::region_of(std::size_t vertex) const {
  if (!ours().independent.quality || vertex >= ours().independent.quality->vertex_region.size()) return "";
  const Quality& quality = *ours().independent.quality;
  const std::size_t label = quality.vertex_region[vertex];
  for (const RegionErrors& region : quality.regions)
    if (label < quality.region_names.size() && region.name == quality.region_names[label]) return region.title;
  return "";
}

std::string ReportView::length(double value) const {
  if (!std::isfinite(value)) return "-";
  return length_text(value * figures_->diagonal, figures_->units) + "\n" + figure_text(value);
}

std::string figure_text(double value) {
  return std::isfinite(value) ? format("%.2e", value) : "-";
}

}  // namespace fb::tool
