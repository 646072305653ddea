// Pictures of what poses cover: ranges of controls as HTML, pairs of controls as an image.
#pragma once

#include <string>
#include <vector>

#include "figures/dataset_figures.h"
#include "render/image.h"

namespace fb::tool {

// HTML: a row for each control that poses use, its range from left to right, the part that is used filled, the default
// marked.
std::string draw_ranges(const std::vector<UsedRange>& controls);

// How often two controls are strongly active at once, as a square with a row and a column for each; blue: never.
Image draw_pairs(const std::vector<float>& pair_shares, std::size_t controls);

}  // namespace fb::tool
