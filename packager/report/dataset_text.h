// What a check of a dataset folder found, read once from the JSON document of fb_check with details.
#pragma once

#include <facebaker/facebaker_bake.hpp>
#include <string>

#include "figures/dataset_figures.h"

namespace fb::tool {

// Of a report of fb_check.
DatasetFigures read_dataset_figures(const facebaker::Report& report);

// For a terminal, and as Markdown.
std::string dataset_text(const DatasetFigures& figures);

}  // namespace fb::tool
