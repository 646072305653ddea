// What was captured of a face: named markers, frame after frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace fb::tool {

struct MarkerTake {
  std::vector<std::string> names;  // UTF-8, each once
  double frames_per_second = 0;    // 0: the file does not say, having one frame
  // Metres in a unit of the file; nothing: the file does not say.
  std::optional<double> metres_per_unit;
  std::size_t frames = 0;
  std::vector<float> positions;       // frames x markers x 3, in units of the file; 0 where missing
  std::vector<std::uint8_t> missing;  // frames x markers, 1: not seen
  std::vector<std::string> notes;     // sentences on what was found odd but read

  std::size_t markers() const { return names.size(); }
  // 3 x markers.
  std::span<const float> positions_of(std::size_t frame) const {
    return std::span(positions).subspan(frame * 3 * markers(), 3 * markers());
  }
  std::span<const std::uint8_t> missing_of(std::size_t frame) const {
    return std::span(missing).subspan(frame * markers(), markers());
  }
};

}  // namespace fb::tool
