// What readers of marker files share: names, coordinates and limits are checked in one place.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "solve/marker_take.h"

namespace fb::tool {

inline constexpr std::size_t most_markers = 4096;

// A coordinate as a file has it, and where that is: "column 7".
struct CoordinateCell {
  std::string_view text;
  std::size_t column = 0;  // counted from 1
};

// The number in a cell; decimal_comma: a comma is as good as a point.
std::optional<double> number_in_cell(std::string_view text, bool decimal_comma);

class TakeBuilder {
 public:
  explicit TakeBuilder(MarkerTake& take) : take_(take) {}

  // Fails with bad_data, if there is no name, or one is empty, no UTF-8 or there twice; with limit beyond most_markers.
  void set_names(std::vector<std::string> names);
  // Appends a frame in which all markers are missing. where: "FILE, line 12, frame 7", for messages of place().
  void begin_frame(std::string where);
  // Places a marker in the last frame, or leaves it missing.
  void place(std::size_t marker, const std::array<CoordinateCell, 3>& cells, bool decimal_comma = false);
  // Adds notes; call it once after the last frame, whose absence it refuses. file: for messages.
  void finish(const std::string& file);

 private:
  [[noreturn]] void fail_at(std::size_t marker, const std::string& reason) const;

  MarkerTake& take_;
  std::string where_;
  std::size_t zeros_ = 0;
};

}  // namespace fb::tool
