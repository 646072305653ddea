// The figures of baked or measured faces, read once from the JSON document of fb_report_details; docs/measuring.md
// explains them. Figures that are not finite are NaN.
#pragma once

#include <cstddef>
#include <facebaker/facebaker_bake.hpp>
#include <string>

#include "figures/face_figures.h"

namespace fb::tool {

struct FrameAddress {
  std::size_t clip = 0, frame = 0;
};

// A sentence on contact, for people.
std::string contact_text(const ContactErrors& contact);

// A sentence on expected errors, and a warning where frames are outside of what was trained.
std::string expectation_text(const Expectation& expected);

// Of a report of bake, compare or eval.
FaceFigures read_figures(const facebaker::Report& report);

}  // namespace fb::tool
