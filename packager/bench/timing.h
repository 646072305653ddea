// A thing that is timed, round after round.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "bench/speed.h"

namespace fb::tool {

// A call of run(pose) evaluates poses_a_call poses.
struct Timing {
  std::string name;
  std::function<void(std::size_t)> run;
  double bytes = 0;
  std::size_t poses_a_call = 1;
  bool elapsed = false;            // time that passes, for what runs on several threads; else the thread's
  double written = 0;              // bytes of results a pose; 0: not known
  std::vector<double> times = {};  // microseconds a pose
  double used = 0, passed = 0;     // of all calls, where elapsed: processor time of all threads, and time

  void measure(std::size_t pose);
  // Of at least one measured call. rounds: how many equal parts the times consist of.
  SpeedLine line(std::size_t rounds) const;
};

// How much the medians of rounds differ: between their quartiles, over the median of all. `times`: round after round,
// all of the same length; 0 for less than two rounds.
double spread_between_rounds(const std::vector<double>& times, std::size_t rounds);

}  // namespace fb::tool
