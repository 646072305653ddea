#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "loaded_rig.h"
#include "support/rig_folder.h"

namespace {

// A folder of its own that FB_SHARED_RIGS points at while it lives.
struct OtherRoot {
  OtherRoot() {
    std::filesystem::create_directories(path / "toy");
    setenv("FB_SHARED_RIGS", path.c_str(), 1);
  }
  ~OtherRoot() {
    unsetenv("FB_SHARED_RIGS");
    std::filesystem::remove_all(path);
  }
  void write(const char* name, const std::string& bytes) const { std::ofstream(path / "toy" / name) << bytes; }

  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("facebaker-rig-folder-" + std::to_string(getpid()));
};

std::string npy(const std::string& header, std::size_t numbers) {
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size());
  bytes += '\0';
  return bytes + header + std::string(4 * numbers, '\0');
}

}  // namespace

TEST_CASE("without data a plugin does not open and says where it looked") {
  const OtherRoot root;
  for (const char* plugin : {FB_PLUGIN_AURA, FB_PLUGIN_MAKEHUMAN}) {
    const LoadedRig rig(plugin);
    CHECK(rig.status == FB_ERROR_RIG);
    CHECK(rig.message.find("there is no rig data in " + root.path.string()) == 0);
    CHECK(rig.message.find("FB_SHARED_RIGS") != std::string::npos);
  }
}

TEST_CASE("arrays are checked before they are believed") {
  const OtherRoot root;
  root.write("rig.json", "{}");
  const std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n", good = npy(header, 6);
  root.write("good.npy", good);
  root.write("short.npy", npy(header, 5));
  root.write("prefix.npy", good.substr(0, 40));
  root.write("empty.npy", "");
  root.write("double.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }\n", 12));
  root.write("columns.npy", npy("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 3), }\n", 6));
  root.write("huge.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (999999999, 999999999), }\n", 6));

  const rigs::RigFolder folder("toy");
  CHECK(folder.floats("good.npy", {0, 3}).shape == std::vector<std::size_t>{2, 3});
  CHECK_THROWS_WITH_AS(folder.floats("good.npy", {0, 4}), doctest::Contains("expected 4"), std::runtime_error);
  CHECK_THROWS_WITH_AS(folder.floats("good.npy", {0}), doctest::Contains("dimensions"), std::runtime_error);
  CHECK_THROWS_WITH_AS(folder.integers("good.npy", {0, 3}), doctest::Contains("<i4"), std::runtime_error);
  CHECK_THROWS_WITH_AS(folder.floats("absent.npy", {0, 3}), doctest::Contains("absent.npy"), std::runtime_error);
  for (const char* bad : {"short.npy", "prefix.npy", "empty.npy", "double.npy", "columns.npy", "huge.npy"}) {
    CAPTURE(bad);
    CHECK_THROWS_WITH_AS(folder.floats(bad, {0, 0}), doctest::Contains(bad), std::runtime_error);
  }
}
