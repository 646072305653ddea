#include "solve/trc_file.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "base/file.h"
#include "base/file_extension.h"
#include "base/length_units.h"
#include "base/parse_number.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "base/utf16.h"
#include "solve/take_builder.h"

namespace fb::tool {
namespace {

constexpr std::uint64_t most_trc_bytes = std::uint64_t{1} << 30;
constexpr std::size_t first_coordinate = 2;  // after the number of the frame and its time

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \r\""), last = text.find_last_not_of(" \r\"");
  return first == std::string_view::npos ? std::string_view() : text.substr(first, last - first + 1);
}

// The cells of a line, without empty ones at its end.
std::vector<std::string_view> cells_of_line(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find('\t', begin), line.size());
    cells.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

class TrcReader {
 public:
  TrcReader(std::string file, std::string_view text) : file_(std::move(file)), rest_(text), builder_(take_) {}

  MarkerTake read() {
    if (!next_line() || !line_.starts_with("PathFileType"))
      fail_here("this is no .trc file: it begins with no PathFileType");
    read_fields();
    read_names();
    if (!next_line()) fail_here("the file ends before its frames");
    if (const auto cells = cells_of_line(line_); !is_frame(cells)) next_row();
    for (; !done_; next_row()) read_frame(cells_of_line(line_));
    builder_.finish(file_);
    if (announced_ && *announced_ != static_cast<long long>(take_.frames))
      take_.notes.push_back(format("NumFrames says %lld frames, and there are %zu", *announced_, take_.frames));
    return std::move(take_);
  }

 private:
  std::string where() const { return format("%s, line %zu", file_.c_str(), number_); }
  [[noreturn]] void fail_here(const std::string& reason) const {
    fail(Status::bad_data, "%s: %s", where().c_str(), reason.c_str());
  }

  // Lines end with \n, \r\n or, in files of old, \r.
  bool next_line() {
    if (done_ || rest_.empty()) {
      done_ = true;
      return false;
    }
    const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end);
    rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : rest_.empty() ? 0 : 1);
    ++number_;
    return true;
  }
  void next_row() {
    while (next_line())
      if (!cells_of_line(line_).empty()) return;
  }

  void read_fields() {
    const std::vector<std::string_view> names = next_line() ? cells_of_line(line_) : std::vector<std::string_view>();
    const std::vector<std::string_view> values = next_line() ? cells_of_line(line_) : std::vector<std::string_view>();
    std::map<std::string, std::string, std::less<>> fields;
    for (std::size_t i = 0; i < names.size(); ++i) fields.emplace(names[i], i < values.size() ? values[i] : "");
    const auto value = [&](const char* name) -> const std::string& {
      const auto field = fields.find(name);
      if (field == fields.end() || field->second.empty())
        fail_here(
            format("there is no %s: lines 2 and 3 have the names and the values of DataRate, NumMarkers, Units "
                   "and others, separated by tabs",
                   name));
      return field->second;
    };
    const std::string& rate = value("DataRate");
    take_.frames_per_second = parse_number<double>(rate).value_or(0);
    if (!(take_.frames_per_second > 0 && take_.frames_per_second < 1e6))
      fail_here(format("DataRate is \"%s\", no number of frames per second", shown(rate).c_str()));
    const std::string& markers = value("NumMarkers");
    const auto count = parse_number<long long>(markers);
    if (!count || *count < 1) fail_here(format("NumMarkers is \"%s\", no number of markers", shown(markers).c_str()));
    markers_ = static_cast<std::size_t>(*count);
    const std::string& unit = value("Units");
    take_.metres_per_unit = metres_per(lower_case(unit));
    if (!take_.metres_per_unit) take_.metres_per_unit = metres_of_word(lower_case(unit));
    if (!take_.metres_per_unit)
      fail_here(format("Units is \"%s\"; it is mm, cm, m, in or another unit of length", shown(unit).c_str()));
    if (const auto frames = fields.find("NumFrames"); frames != fields.end())
      announced_ = parse_number<long long>(frames->second);
  }

  static std::optional<double> metres_of_word(const std::string& unit) {
    constexpr std::pair<const char*, const char*> words[] = {
        {"millimeters", "mm"}, {"millimetres", "mm"}, {"centimeters", "cm"}, {"centimetres", "cm"},
        {"meters", "m"},       {"metres", "m"},       {"inches", "in"},      {"feet", "ft"}};
    for (const auto& [word, name] : words)
      if (unit == word) return metres_per(name);
    return std::nullopt;
  }

  // A marker is named over its first coordinate; some programs leave no empty cells between names.
  void read_names() {
    const std::vector<std::string_view> cells = next_line() ? cells_of_line(line_) : std::vector<std::string_view>();
    if (cells.size() < 2 || lower_case(cells[0]).find("frame") != 0 || lower_case(cells[1]).find("time") != 0)
      fail_here("line 4 does not begin with Frame# and Time, separated by a tab");
    std::vector<std::string> names;
    for (std::size_t i = first_coordinate; i < cells.size(); ++i)
      if (!cells[i].empty()) names.emplace_back(cells[i]);
    if (names.size() != markers_)
      fail_here(format("%zu markers are named, while NumMarkers says %zu", names.size(), markers_));
    with_context(where(), [&] { builder_.set_names(std::move(names)); });
  }

  static bool is_frame(const std::vector<std::string_view>& cells) {
    return !cells.empty() && parse_number<double>(cells[0]);
  }

  void read_frame(const std::vector<std::string_view>& cells) {
    const auto frame = parse_number<long long>(cells[0]);
    if (!frame) fail_here(format("\"%s\" is no number of a frame", shown(cells[0]).c_str()));
    const std::size_t most = first_coordinate + 3 * markers_;
    if (cells.size() > most)
      fail_here(format("frame %lld has %zu cells, while %zu markers have %zu", *frame, cells.size(), markers_, most));
    if (before_ && *frame != *before_ + 1 && !gap_noted_) {
      take_.notes.push_back(
          format("after frame %lld comes frame %lld: frames are taken one after the other", *before_, *frame));
      gap_noted_ = true;
    }
    before_ = frame;
    builder_.begin_frame(format("%s, frame %lld", where().c_str(), *frame));
    const auto cell = [&](std::size_t column) {
      return CoordinateCell{column < cells.size() ? cells[column] : std::string_view(), column + 1};
    };
    for (std::size_t marker = 0; marker < markers_; ++marker) {
      const std::size_t column = first_coordinate + 3 * marker;
      builder_.place(marker, {cell(column), cell(column + 1), cell(column + 2)});
    }
  }

  std::string file_;
  std::string_view rest_, line_;
  std::size_t number_ = 0;  // of the line, from 1
  bool done_ = false, gap_noted_ = false;
  std::size_t markers_ = 0;
  std::optional<long long> announced_, before_;
  MarkerTake take_;
  TakeBuilder builder_;
};

}  // namespace

MarkerTake read_trc_file(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, most_trc_bytes);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (is_utf16(text)) text = with_path(path, [&] { return utf8_from_utf16(text); });
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  return TrcReader(shown(path), text).read();
}

}  // namespace fb::tool
