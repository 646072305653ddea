// Locality of controls: how far a control of an archive moves what it does not move in the rig.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "figures/member_list.h"

namespace fb {

struct LocalityOptions {
  std::uint32_t poses = 6;  // in which every control is moved: 2 from rest, to each end; the others random
  float active = 0.25f;     // share of the other controls that are away from rest in random poses
  double still = 1e-6;      // over D: a vertex that the rig moves no further counts as not moved
  double tolerance = 1e-4;  // over D: largest leak that does not count in Locality::above
  std::uint64_t seed = 1;
};

struct ControlLeak {
  std::string control;
  double leak = 0;           // largest displacement by the archive of a vertex that the rig does not move, over D
  std::uint32_t vertex = 0;  // the vertex with it
  // With all other controls at rest: the poses, those of them of clips that are not trained on, the largest error of a
  // vertex and how far the rig moves one, over D.
  std::size_t alone_poses = 0, unseen_poses = 0;
  double alone_error = 0, alone_motion = 0;
};

struct Locality {
  LocalityOptions options;
  double largest = 0;              // leak of any control
  double above = 0;                // share of the controls whose leak is over the tolerance
  std::vector<ControlLeak> leaks;  // of all controls measured, largest first
  // Recorded poses with one control off rest that this was measured on; 0: a live rig was.
  std::size_t recorded_poses = 0;
};

// Documents list leaks and errors apart: the largest leaks, which are the first of all, and all errors. What was read
// has no leaks but those.
template <class Visit, MaybeConst<Locality> Struct>
void visit_fields(Visit& visit, Struct& locality) {
  constexpr std::ptrdiff_t leaks_listed = 10;
  const auto all = static_cast<std::ptrdiff_t>(locality.leaks.size());
  const auto first = locality.leaks.begin(), end = first + std::min(all, leaks_listed);
  const auto without = std::find_if(first, end, [](const ControlLeak& control) { return control.leak == 0; });
  visit("largest", locality.largest);
  visit("share_above", locality.above);
  visit("tolerance", locality.options.tolerance);
  visit("still", locality.options.still);
  visit("poses", locality.options.poses);
  visit("recorded_poses", locality.recorded_poses);
  visit.derived("controls", locality.leaks.size());
  visit.list("worst", locality.leaks, static_cast<std::size_t>(without - first), [](auto& leaking, auto& control) {
    leaking("control", control.control);
    leaking("leak", control.leak);
    leaking("vertex", control.vertex);
  });
  visit.list("alone", locality.leaks, locality.leaks.size(), [](auto& alone, auto& control) {
    alone("name", control.control);
    alone("poses", control.alone_poses);
    alone("unseen_poses", control.unseen_poses);
    alone("max", control.alone_error);
    alone("motion", control.alone_motion);
  });
}

}  // namespace fb
