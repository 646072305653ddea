#include "commands/open_beside.h"

#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {

facebaker::Source open_beside(const std::string& path, const RigOptions& rigs, const facebaker::Model& model,
                              const std::string& archive, std::vector<std::string>& notes, std::uint64_t clip_budget,
                              std::uint64_t test_poses) {
  facebaker::Source source = rigs.open({path}, notes, clip_budget, test_poses);
  try {
    facebaker::SourceView(source).check_model(model);
  } catch (const facebaker::Error& error) {
    fail(Status(error.status()), "%s beside %s: %s", shown(archive).c_str(), shown(path).c_str(), error.what());
  }
  return source;
}

}  // namespace fb::tool
