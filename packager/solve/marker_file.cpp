#include "solve/marker_file.h"

#include "base/file_extension.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "solve/marker_csv.h"
#include "solve/trc_file.h"

namespace fb::tool {

MarkerTake read_marker_file(const std::filesystem::path& path) {
  const std::string extension = file_extension(path);
  if (extension == ".trc") return read_trc_file(path);
  if (extension == ".csv") return read_marker_csv(path);
  fail(Status::invalid_argument, "%s: captured markers are read from .trc and .csv files", shown(path).c_str());
}

}  // namespace fb::tool
