#include "base/path_inside.h"

#include <system_error>

#include "base/shown_path.h"

namespace fs = std::filesystem;

namespace fb {

fs::path path_inside(const fs::path& folder, const std::string& name) {
  const fs::path file = folder / name;  // `name` alone where it is absolute
  std::error_code error;
  const fs::path found = fs::weakly_canonical(file, error);
  const fs::path inside = error ? fs::path() : fs::canonical(folder.empty() ? "." : folder, error);
  if (error) fail(Status::io, "names \"%s\": %s", shown(name).c_str(), error.message().c_str());
  const fs::path relative = found.lexically_relative(inside);
  const bool outside = fs::path(name).is_absolute() || relative.empty() || *relative.begin() == "..";
  // After a zero byte the system would see no more of the name.
  if (outside || name.find('\0') != std::string::npos)
    fail(Status::bad_data, "names \"%s\", which does not lie in its folder", shown(name).c_str());
  return file;
}

}  // namespace fb
