#include "commands/live_link.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdio>

#include "base/csv_file.h"
#include "base/decimal_points.h"
#include "base/match_names.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "capture/capture_mapping.h"
#include "commands/pose_controls.h"

namespace fb::tool {
namespace {

constexpr double longest_take = 1 << 28;  // values of all frames

// Hours, minutes, seconds and frames, whose rate is not said: "14:03:52:28.207".
struct Timecode {
  double seconds = 0, frames = 0;
  auto operator<=>(const Timecode&) const = default;
};

struct Columns {
  std::size_t timecode = 0;
  std::optional<std::size_t> count;                  // of coefficients: 0 in rows without a face
  std::vector<std::optional<std::size_t>> controls;  // of each column
};

std::string list_text(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
  return text;
}

Columns match_columns(const CsvFile& file, const std::string& path, const facebaker::Model& model, Take& take) {
  std::vector<std::vector<std::string>> columns, controls;
  for (const std::string& name : file.names()) columns.push_back({name});
  for (const fb_control& control : controls_of(model)) controls.push_back({control.arkit, control.name});
  const auto found = match_names({"Timecode", "BlendshapeCount"}, columns);
  if (!found[0])
    fail(Status::bad_data, "%s is no recording of Live Link Face: its first line names no column \"Timecode\"",
         path.c_str());
  Columns matched{*found[0], found[1], match_names(file.names(), controls)};
  std::vector<std::string> unknown;
  std::vector<bool> taken(controls.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    std::optional<std::size_t>& control = matched.controls[i];
    if (i == found[0] || i == found[1]) {
      control.reset();
    } else if (!control) {
      unknown.push_back(file.names()[i]);
    } else if (taken[*control]) {
      fail(Status::bad_data, "%s: two columns are the control \"%s\"", path.c_str(), controls[*control][1].c_str());
    } else {
      taken[*control] = true;
    }
  }
  const auto driven = static_cast<std::size_t>(std::count(taken.begin(), taken.end(), true));
  if (driven == 0)
    fail(Status::invalid_argument,
         "%s: no control of \"%s\" has the ARKit name of a column, such as \"jawOpen\"; give the controls of the "
         "source their ARKit names (\"arkit\" in dataset.json, fb_rig_labels in a rig) and bake it again",
         path.c_str(), fb_name(model.get()));
  if (!unknown.empty()) take.notes.push_back(path + ": no controls have the names " + list_text(unknown));
  if (driven < taken.size())
    take.notes.push_back(format("%s: %zu of %zu controls have no column and stay at rest", path.c_str(),
                                taken.size() - driven, taken.size()));
  return matched;
}

Timecode parse_timecode(const CsvFile& file, const std::string& text) {
  unsigned hours = 0, minutes = 0, seconds = 0;
  Timecode timecode;
  int read = 0;
  const DecimalPoints decimal_points;
  if (std::sscanf(text.c_str(), "%2u:%2u:%2u%*1[:;]%lf%n", &hours, &minutes, &seconds, &timecode.frames, &read) != 4 ||
      read != static_cast<int>(text.size()) || hours > 23 || minutes > 59 || seconds > 59 ||
      !(timecode.frames >= 0 && timecode.frames < 1000))
    fail(Status::bad_data, "%s: the timecode \"%s\" is not hours:minutes:seconds:frames", file.where().c_str(),
         text.c_str());
  timecode.seconds = 60.0 * (60.0 * hours + minutes) + seconds;
  return timecode;
}

// Appends the controls of a row.
void read_row(const CsvFile& file, const Columns& columns, const std::vector<fb_control>& controls,
              std::vector<float>& rows) {
  const std::size_t first = rows.size();
  for (const fb_control& control : controls) rows.push_back(control.rest);
  for (std::size_t i = 0; i < columns.controls.size(); ++i) {
    if (!columns.controls[i]) continue;
    const fb_control& control = controls[*columns.controls[i]];
    const float value = file.number(i);
    if (!std::isfinite(value))
      fail(Status::not_finite, "%s, column \"%s\": %s is no number", file.where().c_str(), file.names()[i].c_str(),
           file.cell(i).c_str());
    rows[first + *columns.controls[i]] = static_cast<float>(control_value(control, value));
  }
}

// How many frames of timecodes are a second: the largest number seen, rounded up to a rate in use. Recordings within
// one second do not show it.
double timecode_rate(const std::vector<Timecode>& timecodes, const std::string& path, Take& take) {
  double largest = 0;
  for (const Timecode& timecode : timecodes) largest = std::max(largest, std::floor(timecode.frames) + 1);
  if (timecodes.front().seconds == timecodes.back().seconds) {
    if (timecodes.size() > 1)
      take.notes.push_back(path + ": within a second; 60 frames of timecodes are taken to be one");
    return std::max(largest, 60.0);
  }
  for (const double rate : {24, 25, 30, 48, 50, 60, 100, 120, 240})
    if (largest <= rate) return rate;
  return largest;
}

// Appends the timecode of a row; false, and nothing, if it is that of the row before. Recordings may go on through
// midnight.
bool add_timecode(const CsvFile& file, Timecode timecode, std::vector<Timecode>& timecodes) {
  if (!timecodes.empty()) {
    const Timecode& before = timecodes.back();
    while (timecode.seconds < before.seconds - 43200) timecode.seconds += 86400;
    if (timecode == before) return false;
    if (timecode < before) fail(Status::bad_data, "%s: the timecode is earlier than that before", file.where().c_str());
  }
  timecodes.push_back(timecode);
  return true;
}

// Seconds since the first row.
std::vector<double> times_of(const std::vector<Timecode>& timecodes, double rate) {
  std::vector<double> times;
  for (const Timecode& timecode : timecodes)
    times.push_back(timecode.seconds - timecodes[0].seconds + (timecode.frames - timecodes[0].frames) / rate);
  return times;
}

// The rate that most rows have, in whole frames a second.
double rate_of(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t row = 1; row < times.size(); ++row) steps.push_back(times[row] - times[row - 1]);
  if (steps.empty()) return 60;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return std::clamp(std::round(1 / *middle), 1.0, 1000.0);
}

// Evenly spaced frames, interpolated linearly between rows.
std::vector<float> resample(const std::vector<double>& times, const std::vector<float>& rows, double fps,
                            const std::string& path) {
  const std::size_t width = rows.size() / times.size();
  const double frames = std::floor(times.back() * fps + 1e-3) + 1;
  if (frames * static_cast<double>(width) > longest_take)
    fail(Status::limit, "%s: %.0f frames in %.0f seconds are too many", path.c_str(), frames, times.back());
  std::vector<float> values;
  std::size_t row = 0;  // the last one that is not later
  for (std::size_t frame = 0; frame < static_cast<std::size_t>(frames); ++frame) {
    const double time = static_cast<double>(frame) / fps;
    while (row + 1 < times.size() && times[row + 1] <= time + 1e-3 / fps) ++row;
    const std::size_t next = std::min(row + 1, times.size() - 1);
    const double past = time - times[row];
    const float part = next == row || past * fps < 1e-3 ? 0.0f : static_cast<float>(past / (times[next] - times[row]));
    for (std::size_t c = 0; c < width; ++c) {
      const float before = rows[row * width + c], after = rows[next * width + c];
      values.push_back(before + part * (after - before));
    }
  }
  return values;
}

}  // namespace

Take read_live_link(const std::string& path, const facebaker::Model& model, std::optional<double> fps) {
  Take take;
  const std::string name = shown(path);
  CsvFile file(path);
  const Columns columns = match_columns(file, name, model, take);
  const std::vector<fb_control> controls = controls_of(model);
  std::vector<Timecode> timecodes;
  std::vector<float> rows;
  std::size_t left_out = 0;
  while (file.next()) {
    const bool face = !columns.count || file.number(*columns.count) > 0;
    if (face && add_timecode(file, parse_timecode(file, file.cell(columns.timecode)), timecodes))
      read_row(file, columns, controls, rows);
    else
      ++left_out;
  }
  if (timecodes.empty()) fail(Status::bad_data, "%s: there are no frames of a face", name.c_str());
  if (left_out > 0)
    take.notes.push_back(
        format("%s: %zu rows without a face or a timecode of their own are left out", name.c_str(), left_out));
  const std::vector<double> times = times_of(timecodes, timecode_rate(timecodes, name, take));
  take.fps = fps ? *fps : rate_of(times);
  take.controls = resample(times, rows, take.fps, name);
  return take;
}

}  // namespace fb::tool
