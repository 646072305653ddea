#include "report/report_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/status.h"

namespace fb::tool {
namespace {

// Recipes by what a reader wants to see of a face, the last first wanted; any other recipe comes before them.
constexpr std::array<const char*, 4> least_to_most = {"linear", "paper", "compact", "hero"};

std::size_t rank(const std::string& name) {
  const auto at = std::find(least_to_most.begin(), least_to_most.end(), name);
  if (name == "linear") return 0;
  return at == least_to_most.end() ? 1 : 1 + static_cast<std::size_t>(at - least_to_most.begin());
}

}  // namespace

ReportView::ReportView(const CompareReport& faces) : faces_(&faces) {
  const auto& all = methods();
  for (std::size_t m = 1; m < all.size(); ++m) {
    const std::size_t mine = rank(all[m].name), best = rank(all[ours_].name);
    if (mine > best || (mine == best && all[m].name == all[ours_].name && all[m].use < all[ours_].use)) ours_ = m;
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
  return both ? method.name + " " + name_of(method.use) : method.name;
}

int ReportView::colour(const MethodReport& method) const {
  const auto at = std::find(recipes_.begin(), recipes_.end(), method.name);
  if (at == recipes_.end()) return 0;
  if (method.name == ours().name) return 1;
  const auto own = std::find(recipes_.begin(), recipes_.end(), ours().name);
  return at < own ? 2 + static_cast<int>(at - recipes_.begin()) : 1 + static_cast<int>(at - recipes_.begin());
}

std::string figure_text(double value) {
  return std::isfinite(value) ? format("%.2e", value) : "-";
}

}  // namespace fb::tool
