#include "tidy_tree.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

using checks::SourceTree;

namespace {

const std::filesystem::path root = FB_SOURCE_ROOT;

std::string typed_version() {
  std::string version;
  std::getline(std::ifstream(root / "VERSION"), version);
  return version;
}

void none(const std::vector<std::string>& offences) {
  for (const std::string& offence : offences) FAIL_CHECK(offence);
}

}  // namespace

TEST_CASE("the tree is tidy") {
  const SourceTree tree = checks::read_source_tree(root);
  none(checks::stray_openmp(tree));
  none(checks::repeated_names(tree));
  none(checks::long_files(tree));
  none(checks::long_functions(tree));
  const std::string version = typed_version();
  REQUIRE(version.size() >= 5);
  none(checks::typed_versions(tree, version));
  none(checks::pinned_packages(tree));
  none(checks::ranges_in_runtime(tree));
  none(checks::shared_streams(tree));
}

TEST_CASE("the site's navigation has every page") {
  std::ifstream file(root / "docs" / "site" / "mkdocs.yml");
  const std::string navigation(std::istreambuf_iterator<char>(file), {});
  std::size_t pages = 0;
  for (const auto& entry : std::filesystem::directory_iterator(root / "docs")) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".md") || name == "reference.md") continue;  // that is Doxygen's front page
    ++pages;
    CHECK_MESSAGE(navigation.find(": docs/" + name + "\n") != std::string::npos, name);
  }
  CHECK(pages > 20);
}

TEST_CASE("the top of the tree holds what it is meant to hold") {
  const std::set<std::string> entries = {"CHANGELOG.md",
                                         "CMakeLists.txt",
                                         "CMakePresets.json",
                                         "CONTRIBUTING.md",
                                         "LICENSE",
                                         "README.md",
                                         "SECURITY.md",
                                         "VERSION",
                                         "bindings",
                                         "capi",
                                         "core",
                                         "docs",
                                         "packager",
                                         "packages",
                                         "samples",
                                         "tests",
                                         "build",
                                         "install"};
  for (const auto& entry : std::filesystem::directory_iterator(root)) {
    const std::string name = entry.path().filename().string();
    if (name[0] != '.' && !entries.contains(name)) FAIL_CHECK("a stray " << name);
  }
}

TEST_CASE("stray OpenMP pragmas are found") {
  CHECK(checks::stray_openmp({{"core/base/parallel.cpp", "#pragma omp parallel for\n"}}).empty());
  CHECK(checks::stray_openmp({{"core/base/x.cpp", "// about #pragma omp\n#pragma once\n"}}).empty());
  CHECK(checks::stray_openmp({{"core/base/x.cpp", "int a;\n # pragma omp simd\n"}}).size() == 1);
  CHECK(checks::stray_openmp({{"packager/x.h", "_Pragma(\"omp parallel\")"}}).size() == 1);
}

TEST_CASE("repeated names are found") {
  CHECK(checks::repeated_names({{"core/CMakeLists.txt", ""}, {"capi/CMakeLists.txt", ""}}).empty());
  CHECK(checks::repeated_names({{"core/base/hash.h", ""}, {"core/base/hash.cpp", ""}}).empty());
  CHECK(checks::repeated_names({{"core/base/hash.h", ""}, {"samples/hash.h", ""}}).size() == 1);
}

TEST_CASE("long files are found") {
  CHECK(checks::long_files({{"a.py", std::string(600, '\n')}}).empty());
  CHECK(checks::long_files({{"a.py", std::string(601, '\n')}}).size() == 1);
}

TEST_CASE("long functions are found") {
  const auto function = [](const char* path, std::size_t lines) {
    return checks::long_functions({{path, "namespace fb {\nint f(\n    int a) {\n" + std::string(lines - 3, '\n') +
                                              "}\n\n}  // namespace fb\n"}});
  };
  CHECK(function("core/base/x.cpp", 60).empty());
  CHECK(function("tests/x.cpp", 61).empty());
  REQUIRE(function("core/base/x.cpp", 61).size() == 1);
  CHECK(function("core/base/x.cpp", 61)[0] == "core/base/x.cpp:2: a function of 61 lines");
}

TEST_CASE("typed versions are found") {
  const auto typed = [](const char* path, const char* text) { return checks::typed_versions({{path, text}}, "1.2.3"); };
  CHECK(typed("CHANGELOG.md", "## 1.2.3").empty());
  CHECK(typed("a.py", "11.2.3 1.2.34 0.1.2.3").empty());
  CHECK(typed("a.py", "version = \"1.2.3\"").size() == 1);
  CHECK(typed("README.md", "This is 1.2.3.").size() == 1);
}

TEST_CASE("packages in a version are found") {
  const auto pinned = [](const char* path, const char* text) { return checks::pinned_packages({{path, text}}); };
  CHECK(pinned("core/CMakeLists.txt", "find_package(draco REQUIRED CONFIG) # 1.5\nset(x 2)\n").empty());
  CHECK(pinned("docs/x.md", "find_package(Eigen3 3.4 REQUIRED)").empty());
  CHECK(pinned("core/CMakeLists.txt", "if(A)\n  find_package(Eigen3 3.4 REQUIRED NO_MODULE)\n").size() == 1);
  CHECK(pinned("core/x.cmake", "fb_find_package(ZLIB::ZLIB ZLIB 1.2...1.9 REQUIRED)").size() == 1);
}

TEST_CASE("ranges that WebAssembly does not build with are found") {
  const auto ranges = [](const char* path) {
    return checks::ranges_in_runtime({{path, "std::ranges::copy(a, b);\n"}});
  };
  CHECK(ranges("core/base/csv_file.cpp").empty());
  CHECK(ranges("core/bake/train/x.cpp").empty());
  CHECK(ranges("core/runtime/x.h").size() == 1);
  CHECK(ranges("core/base/x.cpp").size() == 1);
}

TEST_CASE("random numbers of no use of the seed, and of one that is named elsewhere, are found") {
  const auto offences = [](const std::string& text) {
    return checks::shared_streams({{"core/bake/a.cpp", "Random random = open_stream(seed, Stream::poses, i);\n"},
                                   {"core/bake/b.cpp", text}})
        .size();
  };
  CHECK(offences("Random random = open_stream(seed, Stream::order);\nfloat draw(Random& random);\n") == 0);
  CHECK(offences("open_stream(seed, Stream::poses, 0);\n") == 1);
  CHECK(offences("open_stream(seed, Stream::order); open_stream(seed, Stream::order);\n") == 1);
  CHECK(offences("Random random(seed);\n") == 1);
  CHECK(offences("return Random(seed, 2).next();\n") == 1);
  CHECK(offences("Random random{seed};\n") == 1);
  CHECK(checks::shared_streams({{"tests/a.cpp", "Random random(3);\n"}}).empty());
}
