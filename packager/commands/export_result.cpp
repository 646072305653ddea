#include "commands/export_result.h"

#include "base/status.h"

namespace fb::tool {

void ExportResult::add_error(const std::string& key, const std::string& what, const MorphError& error, double diagonal,
                             const std::string& units) {
  lines.push_back(format("%s: off by at most %.2g %s (%.1e of the diagonal), rms %.2g %s (%.1e)", what.c_str(),
                         error.largest, units.c_str(), error.largest / diagonal, error.rms(), units.c_str(),
                         error.rms() / diagonal));
  figures[key] = {{"max", error.largest},
                  {"rms", error.rms()},
                  {"max_over_diagonal", error.largest / diagonal},
                  {"rms_over_diagonal", error.rms() / diagonal}};
}

void ExportResult::add_driven_joints_note(const CharacterView& character) {
  if (!character.driven_joints.empty())
    notes.push_back(
        format("%zu driven joints are left out, and vertices go where they take them; \"facebaker pose\" "
               "writes a pose or a clip as .glb with them",
               character.driven_joints.size()));
}

}  // namespace fb::tool
