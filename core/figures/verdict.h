// How far a face is off, in a sentence: the first thing that whoever bakes wants to know.
#pragma once

#include <algorithm>
#include <string>

#include "base/length_units.h"
#include "base/status.h"
#include "figures/face_figures.h"

namespace fb {

// Of poses that are called `poses`, such as "unseen frames"; `where` the worst vertex is, or "".
inline std::string verdict_text(const Errors& errors, const std::string& poses, const std::string& where,
                                double diagonal, const std::string& units) {
  const auto length = [&](double over_diagonal) { return length_text(over_diagonal * diagonal, units); };
  return format(
      "Worst vertex of %zu %s: off by %s%s. The worst vertex of 99 in 100 is off by at most %s, on average by %s.",
      errors.frames, poses.c_str(), length(errors.max).c_str(), where.empty() ? "" : (" (" + where + ")").c_str(),
      length(errors.p99fm).c_str(), length(errors.mfm).c_str());
}

// Of the frames that a face was measured on; "" if there are none. The place on the face is known with Detail::quality.
inline std::string verdict_text(const EvalReport& report) {
  if (report.total.frames == 0) return "";
  const ClipErrors& worst =
      *std::ranges::max_element(report.clips, {}, [](const ClipErrors& c) { return c.errors.max; });
  const std::string place = report.worst.empty() ? "" : report.worst.front().place + ", ";
  const std::string where = place + format("frame %zu of \"%s\"", worst.errors.worst_frame, worst.name.c_str());
  return verdict_text(report.total, "frames", where, report.diagonal, report.units);
}

}  // namespace fb
