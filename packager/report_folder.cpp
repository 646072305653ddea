#include "report_folder.h"

#include <system_error>

#include "base/file.h"
#include "base/status.h"

namespace fb {

void write_report(const std::filesystem::path& folder, const std::string& name, const std::string& json,
                  const std::string& table) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail(Status::io, "%s: cannot be made: %s", folder.c_str(), error.message().c_str());
  write_file(folder / (name + ".json"), json);
  write_file(folder / (name + ".md"), table);
}

}  // namespace fb
