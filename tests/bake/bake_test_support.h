// What the tests of rig sources, datasets and sampling share.
#pragma once

#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "bake/rig/source.h"
#include "base/status.h"

namespace fb::test {

// An empty folder that is gone afterwards.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "facebaker-XXXXXX").string();
    REQUIRE(mkdtemp(pattern.data()) != nullptr);
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::unique_ptr<Source> open_toy() {
  return open_source(FB_TOY_RIG);
}

// The toy rig with one lie (lying_rig.c lists them).
inline std::unique_ptr<Source> open_liar(const char* lie) {
  setenv("FB_LIE", lie, 1);
  return open_source(FB_LYING_RIG);
}

// The message `work` fails with; fails the test if it does not fail with this status.
template <class Work>
std::string failure(Status status, Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    CHECK_MESSAGE(error.status() == status, error.what());
    return error.what();
  }
  FAIL("nothing failed");
  return "";
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace fb::test
