#pragma once

#include <string>
#include <vector>

#include "bake/recipe/recipe.h"

namespace fb::bake {

std::vector<std::string> recipe_names();

// Fails with not_found, listing the recipes there are.
const Recipe& recipe_named(const std::string& name);

}  // namespace fb::bake
