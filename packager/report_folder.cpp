#include "report_folder.h"

#include "base/file.h"

namespace fb {

void write_report(const std::filesystem::path& folder, const std::string& name, const std::string& json,
                  const std::string& table) {
  make_folder(folder);
  write_file(folder / (name + ".json"), json);
  write_file(folder / (name + ".md"), table);
}

}  // namespace fb
