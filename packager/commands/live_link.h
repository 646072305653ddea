// Recordings of Live Link Face, Epic's app for facial capture: .csv files with a row a frame and a column for each of
// ARKit's face blendshapes, and turns of head and eyes.
#pragma once

#include <facebaker/facebaker.hpp>
#include <optional>
#include <string>
#include <vector>

namespace fb::tool {

struct Take {
  std::vector<float> controls;  // frames x controls
  double fps = 0;
  std::vector<std::string> notes;  // sentences: columns and controls without a counterpart, rows left out
};

// A recording as frames of a face's controls, evenly spaced in time: at the rate it was recorded with, or at `fps`
// frames a second, interpolated between rows. Columns are matched to ARKit names of controls, or else to their own
// names. A coefficient is the value of its control, or, if the control has a unit, the part of the way from rest to
// the upper end of its range; controls without a column stay at rest. Fails, naming file and line, on what is no such
// recording, and with advice if no control has an ARKit name.
Take read_live_link(const std::string& path, const facebaker::Model& model, std::optional<double> fps);

}  // namespace fb::tool
