#include "bake/pipeline/recipe_table.h"

#include <array>

#include "bake/baselines/baselines.h"
#include "bake/face/face_recipe.h"
#include "bake/face/untrained.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::array recipes = {Recipe{"linear", make_linear, true, false, false, Learning::recordings},
                                Recipe{"kanyuk2018", make_kanyuk2018},
                                Recipe{"bailey2018", make_bailey2018},
                                Recipe{"kavan2024", make_kavan2024, false, true},
                                Recipe{"paper", make_paper},
                                Recipe{"paper-tuned", make_paper_tuned},
                                Recipe{"paper-gradients", make_paper_gradients},
                                Recipe{"compact", make_compact, true, true, true},
                                Recipe{"hero", make_hero, true, true, true},
                                Recipe{"untrained", make_untrained, true, true, true, Learning::nothing}};

}  // namespace

const Recipe& find_recipe(const std::string& name) {
  std::string list;
  for (const Recipe& recipe : recipes) {
    if (name == recipe.name) return recipe;
    list += (list.empty() ? "" : ", ") + std::string(recipe.name);
  }
  fail(Status::not_found, "there is no recipe \"%s\"; there are %s", name.c_str(), list.c_str());
}

std::vector<std::string> recipe_names() {
  std::vector<std::string> names;
  for (const Recipe& recipe : recipes) names.push_back(recipe.name);
  return names;
}

}  // namespace fb::bake
