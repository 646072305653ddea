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

}  // namespace fb::tool
