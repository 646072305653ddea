#include "solve/take_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/file_extension.h"
#include "base/parse_number.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "base/utf8.h"

namespace fb::tool {
namespace {

constexpr std::size_t most_positions = std::size_t{32} << 20;
constexpr double farthest = 1000;  // metres

bool is_missing(std::string_view text) {
  return text.empty() || lower_case(text) == "nan";
}

}  // namespace

std::optional<double> number_in_cell(std::string_view text, bool decimal_comma) {
  std::string copy(text.substr(text.starts_with('+') ? 1 : 0));
  if (decimal_comma) std::ranges::replace(copy, ',', '.');
  return parse_number<double>(copy);
}

void TakeBuilder::set_names(std::vector<std::string> names) {
  if (names.empty()) fail(Status::bad_data, "no markers are named");
  if (names.size() > most_markers) fail(Status::limit, "%zu markers; at most %zu are read", names.size(), most_markers);
  std::map<std::string, std::size_t> numbers;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) fail(Status::bad_data, "marker %zu has no name", i + 1);
    if (const auto fault = find_utf8_fault(names[i]))
      fail(Status::bad_data, "the name of marker %zu, \"%s\", is no UTF-8 at byte %zu", i + 1, shown(names[i]).c_str(),
           *fault);
    const auto [same, fresh] = numbers.try_emplace(names[i], i);
    if (!fresh)
      fail(Status::bad_data, "markers %zu and %zu are both named \"%s\"", same->second + 1, i + 1,
           shown(names[i]).c_str());
  }
  take_.names = std::move(names);
}

void TakeBuilder::begin_frame(std::string where) {
  where_ = std::move(where);
  if (take_.missing.size() + take_.markers() > most_positions)
    fail(Status::limit, "%s: more than %zu positions of markers", where_.c_str(), most_positions);
  ++take_.frames;
  take_.positions.resize(take_.frames * take_.markers() * 3);
  take_.missing.resize(take_.frames * take_.markers(), 1);
}

void TakeBuilder::fail_at(std::size_t marker, const std::string& reason) const {
  fail(Status::bad_data, "%s, marker \"%s\": %s", where_.c_str(), shown(take_.names[marker]).c_str(), reason.c_str());
}

void TakeBuilder::place(std::size_t marker, const std::array<CoordinateCell, 3>& cells, bool decimal_comma) {
  const auto absent = std::ranges::count_if(
      cells, [](std::string_view text) { return is_missing(text); }, &CoordinateCell::text);
  if (absent == 3) return;
  std::array<float, 3> position{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const CoordinateCell& cell = cells[axis];
    if (is_missing(cell.text))
      fail_at(marker, format("column %zu, %c, is empty while others are not: leave all three empty where it is missing",
                             cell.column, "xyz"[axis]));
    const std::optional<double> value = number_in_cell(cell.text, decimal_comma);
    if (!value || !std::isfinite(*value))
      fail_at(marker, format("column %zu: \"%s\" is no %s", cell.column, shown(cell.text).c_str(),
                             value ? "position" : "number"));
    if (std::abs(*value) * take_.metres_per_unit.value_or(0.001) > farthest)
      fail_at(marker, format("column %zu: %s is more than a kilometre away: leave the three cells of a missing marker "
                             "empty, and check the unit",
                             cell.column, shown(cell.text).c_str()));
    position[axis] = static_cast<float>(*value);
  }
  if (position == std::array<float, 3>{}) {
    ++zeros_;
    return;
  }
  const std::size_t at = (take_.frames - 1) * take_.markers() + marker;
  std::ranges::copy(position, &take_.positions[3 * at]);
  take_.missing[at] = 0;
}

void TakeBuilder::finish(const std::string& file) {
  if (take_.frames == 0) fail(Status::bad_data, "%s: no frames", file.c_str());
  if (zeros_ > 0)
    take_.notes.push_back(
        format("%zu positions are 0, 0, 0, as some programs write missing markers: they are left out", zeros_));
  for (std::size_t marker = 0; marker < take_.markers(); ++marker) {
    bool seen = false;
    for (std::size_t frame = 0; frame < take_.frames && !seen; ++frame)
      seen = take_.missing[frame * take_.markers() + marker] == 0;
    if (!seen) take_.notes.push_back(format("the marker \"%s\" is in no frame", shown(take_.names[marker]).c_str()));
  }
}

}  // namespace fb::tool
