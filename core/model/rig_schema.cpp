#include "model/rig_schema.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory_resource>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

#include "base/status.h"

namespace fb {

float Control::reach() const {
  return std::max(maximum - rest, rest - minimum);
}

std::optional<std::size_t> RigSchema::find(std::string_view control) const {
  for (std::size_t i = 0; i < controls.size(); ++i)
    if (controls[i].name == control) return i;
  if (control.empty()) return std::nullopt;
  for (std::string ControlLabels::*const label : {&ControlLabels::arkit, &ControlLabels::facs})
    for (std::size_t i = 0; i < controls.size(); ++i)
      if (controls[i].labels.*label == control) return i;
  return std::nullopt;
}

std::string_view RigSchema::closest(std::string_view misspelt) const {
  // Levenshtein distance, one row of the table at a time, case-insensitive. The bound, in entries of all tables: 2,000
  // names of 60 letters against one of 60.
  constexpr std::size_t max_entries = std::size_t(1) << 23;
  std::size_t entries = 0;
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  std::string_view best;
  std::size_t fewest = SIZE_MAX;
  if (misspelt.size() > max_entries) return best;
  std::vector<std::size_t> row(misspelt.size() + 1);
  for (const Control& control : controls) {
    const std::size_t more = (control.name.size() + 1) * row.size();
    if (more > max_entries - entries) continue;
    entries += more;
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < control.name.size(); ++i) {
      std::size_t diagonal = row[0]++;
      for (std::size_t j = 0; j < misspelt.size(); ++j) {
        const std::size_t replaced = diagonal + (lower(control.name[i]) != lower(misspelt[j]));
        diagonal = row[j + 1];
        row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
      }
    }
    if (row.back() < fewest) {
      fewest = row.back();
      best = control.name;
    }
  }
  return best;
}

std::vector<float> RigSchema::rest_pose() const {
  std::vector<float> pose;
  pose.reserve(controls.size());
  for (const Control& control : controls) pose.push_back(control.rest);
  return pose;
}

namespace {

// `names`: those of all controls.
void check_labels(const RigSchema& schema, const std::pmr::unordered_map<std::string_view, std::size_t>& names,
                  std::pmr::memory_resource& memory) {
  std::pmr::unordered_set<std::string_view> arkit(&memory), facs(&memory);
  for (const Control& c : schema.controls) {
    const ControlLabels& labels = c.labels;
    if (!labels.arkit.empty() && !arkit.insert(labels.arkit).second)
      fail(Status::bad_data, "two controls have the ARKit name \"%s\"", labels.arkit.c_str());
    if (!labels.facs.empty() && !facs.insert(labels.facs).second)
      fail(Status::bad_data, "two controls have the FACS name \"%s\"", labels.facs.c_str());
    if (labels.mirror.empty()) continue;
    const auto partner = names.find(labels.mirror);
    if (partner == names.end())
      fail(Status::bad_data, "control \"%s\" mirrors \"%s\", which is no control", c.name.c_str(),
           labels.mirror.c_str());
    if (schema.controls[partner->second].labels.mirror != c.name || labels.mirror == c.name)
      fail(Status::bad_data, "control \"%s\" mirrors \"%s\", which does not mirror it", c.name.c_str(),
           labels.mirror.c_str());
  }
}

// Of a control or a channel.
template <class Item>
void check_range(const char* what, std::size_t index, const Item& item) {
  const char* name = item.name.c_str();
  if (!*name) fail(Status::bad_data, "%s %zu has no name", what, index);
  if (!std::isfinite(item.minimum) || !std::isfinite(item.maximum) || !std::isfinite(item.rest))
    fail(Status::not_finite, "%s \"%s\": its range or default is not a number", what, name);
  if (!(item.minimum < item.maximum))
    fail(Status::bad_data, "%s \"%s\": minimum %g is not below maximum %g", what, name, double(item.minimum),
         double(item.maximum));
  if (item.rest < item.minimum || item.rest > item.maximum)
    fail(Status::bad_data, "%s \"%s\": default %g is outside its range %g..%g", what, name, double(item.rest),
         double(item.minimum), double(item.maximum));
}

}  // namespace

void check(const RigSchema& schema) {
  if (schema.up_axis != "y" && schema.up_axis != "z")
    fail(Status::bad_data, "rig \"%s\": the up axis is \"%s\", not \"y\" or \"z\"", schema.name.c_str(),
         schema.up_axis.c_str());
  if (schema.controls.empty()) fail(Status::bad_data, "rig \"%s\" has no controls", schema.name.c_str());
  std::pmr::monotonic_buffer_resource memory;  // a few blocks instead of one a name
  std::pmr::unordered_map<std::string_view, std::size_t> names(&memory);
  for (const Control& c : schema.controls) {
    if (!names.emplace(c.name, names.size()).second)
      fail(Status::bad_data, "control name \"%s\" occurs twice", c.name.c_str());
    check_range("control", names.size() - 1, c);
  }
  check_labels(schema, names, memory);
  std::pmr::unordered_set<std::string_view> channels(&memory);
  for (const Channel& c : schema.channels) {
    if (!channels.insert(c.name).second) fail(Status::bad_data, "channel name \"%s\" occurs twice", c.name.c_str());
    check_range("channel", channels.size() - 1, c);
  }
}

void check_same_controls(const RigSchema& a, const char* a_name, const RigSchema& b, const char* b_name) {
  if (a.controls.size() != b.controls.size())
    fail(Status::bad_data, "%s has %zu controls, %s has %zu", a_name, a.controls.size(), b_name, b.controls.size());
  for (std::size_t i = 0; i < a.controls.size(); ++i) {
    const Control &x = a.controls[i], &y = b.controls[i];
    if (x.name != y.name)
      fail(Status::bad_data, "control %zu is \"%s\" in %s and \"%s\" in %s", i, x.name.c_str(), a_name, y.name.c_str(),
           b_name);
    if (x.minimum != y.minimum || x.maximum != y.maximum || x.rest != y.rest)
      fail(Status::bad_data, "control \"%s\" has another range or default in %s than in %s", x.name.c_str(), a_name,
           b_name);
  }
}

void check_same_channels(const RigSchema& a, const char* a_name, const RigSchema& b, const char* b_name) {
  if (a.channels.size() != b.channels.size())
    fail(Status::bad_data, "%s has %zu channels, %s has %zu", a_name, a.channels.size(), b_name, b.channels.size());
  for (std::size_t i = 0; i < a.channels.size(); ++i) {
    const Channel &x = a.channels[i], &y = b.channels[i];
    if (x.name != y.name)
      fail(Status::bad_data, "channel %zu is \"%s\" in %s and \"%s\" in %s", i, x.name.c_str(), a_name, y.name.c_str(),
           b_name);
    if (x.minimum != y.minimum || x.maximum != y.maximum || x.rest != y.rest)
      fail(Status::bad_data, "channel \"%s\" has another range or default in %s than in %s", x.name.c_str(), a_name,
           b_name);
  }
}

}  // namespace fb
