// The constants of the cost of poses (pose_cost.h) on this machine.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "bake/measure/pose_cost.h"
#include "base/progress.h"

namespace fb::bake {

// Poses of about the same work, and the time that one takes.
struct TimedWork {
  PoseWork work = {};
  double microseconds = 0;  // above 0
};

// Nanoseconds of each kind of work, 0 or more, with the least sum of squared relative errors.
PoseWork fit_nanoseconds(std::span<const TimedWork> cases);

struct Calibration {
  MachineClass machine;
  std::vector<TimedWork> cases;
  double rms_error = 0, worst_error = 0;  // of the prediction over the measured time
};

// Times poses of made-up faces of many sizes with the instruction set that the runtime chooses, on the calling thread:
// some seconds.
Calibration calibrate_machine(Progress& progress);

}  // namespace fb::bake
