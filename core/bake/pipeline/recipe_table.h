#pragma once

#include <string>
#include <vector>

#include "bake/recipe/recipe.h"

namespace fb::bake {

// In the order in which they were published, our own last.
std::vector<std::string> recipe_names();

// Fails with not_found, listing the recipes.
const Recipe& find_recipe(const std::string& name);

}  // namespace fb::bake
