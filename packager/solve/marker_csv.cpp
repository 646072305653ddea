#include "solve/marker_csv.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/csv_file.h"
#include "base/file_extension.h"
#include "base/parse_number.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "solve/take_builder.h"

namespace fb::tool {
namespace {

// Of a line of names, which columns have what.
struct MarkerColumns {
  std::size_t time = 0;
  std::vector<std::string> names;
  std::vector<std::array<std::size_t, 3>> axes;  // of each marker, counted from 1; 0: none
};

// "brow.x" is {"brow", 0}.
std::optional<std::pair<std::string, std::size_t>> marker_and_axis(const std::string& column) {
  if (column.size() < 3) return std::nullopt;
  const std::size_t axis = std::string("xyz").find(lower_case(column.substr(column.size() - 1)));
  const std::size_t mark = column.size() - 2;
  if (axis == std::string::npos || std::string("._: ").find(column[mark]) == std::string::npos) return std::nullopt;
  return std::pair(column.substr(0, mark), axis);
}

MarkerColumns columns_of(const std::vector<std::string>& names) {
  MarkerColumns columns;
  bool timed = false;
  std::map<std::string, std::size_t> markers;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const std::string name = lower_case(names[c]);
    if (name == "frame" || name == "frame#") continue;
    if (name == "time") {
      if (timed) fail(Status::bad_data, "columns %zu and %zu are both \"time\"", columns.time + 1, c + 1);
      timed = true;
      columns.time = c;
      continue;
    }
    const auto found = marker_and_axis(names[c]);
    if (!found)
      fail(Status::bad_data, "column %zu is \"%s\": columns are \"time\", \"frame\" and NAME.x, NAME.y, NAME.z", c + 1,
           shown(names[c]).c_str());
    const auto [marker, fresh] = markers.try_emplace(found->first, columns.names.size());
    if (fresh) {
      columns.names.push_back(found->first);
      columns.axes.emplace_back();
    }
    std::size_t& axis = columns.axes[marker->second][found->second];
    if (axis != 0)
      fail(Status::bad_data, "columns %zu and %zu are both the %c of \"%s\"", axis, c + 1, "xyz"[found->second],
           shown(found->first).c_str());
    axis = c + 1;
  }
  if (!timed) fail(Status::bad_data, "there is no column \"time\"");
  for (std::size_t m = 0; m < columns.names.size(); ++m)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (columns.axes[m][axis] == 0)
        fail(Status::bad_data, "the marker \"%s\" has no column for its %c", shown(columns.names[m]).c_str(),
             "xyz"[axis]);
  return columns;
}

// Frames follow each other evenly: the rate.
double rate_of(const std::vector<double>& times, const std::vector<std::size_t>& lines, const std::string& file) {
  if (times.size() < 2) return 0;
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double taken = times[i] - times[i - 1];
    if (!(step > 1e-6) || !(taken > 0.5 * step) || !(taken < 1.5 * step))
      fail(Status::bad_data,
           "%s, line %zu: the time goes from %g to %g s, while all frames together have steps of %g s: frames have "
           "equal steps of time; write those that were not captured, with empty cells",
           file.c_str(), lines[i], times[i - 1], times[i], step);
  }
  return 1 / step;
}

}  // namespace

MarkerTake read_marker_csv(const std::filesystem::path& path) {
  CsvFile file(path);
  const std::string shown_path = shown(path);
  MarkerTake take;
  TakeBuilder builder(take);
  const MarkerColumns columns = with_context(file.where(), [&] {
    MarkerColumns found = columns_of(file.names());
    builder.set_names(found.names);
    return found;
  });
  std::vector<double> times;
  std::vector<std::size_t> lines;
  const bool decimal_comma = true;  // a cell has none where commas separate cells
  while (file.next()) {
    const std::optional<double> time = number_in_cell(file.cell(columns.time), decimal_comma);
    if (!time || !std::isfinite(*time))
      fail(Status::bad_data, "%s: the time is \"%s\", no number of seconds", file.where().c_str(),
           shown(file.cell(columns.time)).c_str());
    times.push_back(*time);
    lines.push_back(file.line());
    builder.begin_frame(format("%s, frame %zu", file.where().c_str(), times.size()));
    for (std::size_t m = 0; m < columns.axes.size(); ++m) {
      std::array<CoordinateCell, 3> cells;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t column = columns.axes[m][axis];
        cells[axis] = {file.cell(column - 1), column};
      }
      builder.place(m, cells, decimal_comma);
    }
  }
  builder.finish(shown_path);
  take.frames_per_second = rate_of(times, lines, shown_path);
  return take;
}

}  // namespace fb::tool
