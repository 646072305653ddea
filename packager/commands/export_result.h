#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "export/character_view.h"
#include "export/morph_targets.h"

namespace fb::tool {

// What an export tells: of what was written, for people and programs.
struct ExportResult {
  std::vector<std::string> lines;  // for people
  nlohmann::ordered_json figures;
  std::vector<std::string> notes;  // sentences: what was left out

  // A line "what: off by ...", and the same among the figures. Distances are in the units of the face.
  void add_error(const std::string& key, const std::string& what, const MorphError& error, double diagonal,
                 const std::string& units);
  // A note about the driven joints of a face, if it has any.
  void add_driven_joints_note(const CharacterView& character);
};

}  // namespace fb::tool
