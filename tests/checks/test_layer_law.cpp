#include "layer_law.h"

#include <doctest/doctest.h>

using checks::layer_violations;
using checks::SourceTree;

TEST_CASE("the tree keeps the law of layers") {
  const SourceTree tree = checks::read_source_tree(FB_SOURCE_ROOT);
  REQUIRE(tree.size() > 50);
  for (const std::string& violation : layer_violations(tree)) FAIL_CHECK(violation);
  for (const std::string& circle : checks::folder_circles(tree)) FAIL_CHECK(circle);
  for (const std::string& offence : checks::stray_namespaces(tree)) FAIL_CHECK(offence);
}

namespace {

struct Planted {
  const char *path, *include;
};

// Violations of a tree that has a file of every layer, and one more with an include in its second line.
std::vector<std::string> violations_of(const Planted& plant) {
  SourceTree tree = {{"core/base/file.h", ""},
                     {"core/model/mesh.h", ""},
                     {"core/figures/face_figures.h", ""},
                     {"core/archive/reader.h", ""},
                     {"core/archive/section_writer.h", ""},
                     {"core/archive/coding/writer/choose_predictors.h", ""},
                     {"core/runtime/evaluator.h", ""},
                     {"core/bake/rig/source.h", ""},
                     {"core/bake/dataset/npy.h", ""},
                     {"core/bake/analysis/sparse_blendshapes.h", ""},
                     {"core/bake/train/trainer.h", ""},
                     {"core/bake/measure/errors.h", ""},
                     {"core/bake/face/face_recipe.h", ""},
                     {"core/bake/baselines/baselines.h", ""},
                     {"core/bake/pipeline/bake.h", ""},
                     {"capi/include/facebaker/facebaker.h", ""},
                     {"capi/bake/authoring.h", ""},
                     {"capi/abi_guard.h", ""},
                     {"packager/commands.h", ""},
                     {"samples/hello/hello.h", ""},
                     {"tests/rigs/support/skin.h", ""},
                     {plant.path, std::string("// first\n  # include ") + plant.include + "\n"}};
  return layer_violations(tree);
}

}  // namespace

TEST_CASE("planted violations are caught") {
  const Planted forbidden[] = {
      {"core/base/x.cpp", "\"model/mesh.h\""},
      {"core/figures/x.h", "\"model/mesh.h\""},
      {"core/figures/x.h", "\"bake/measure/errors.h\""},
      {"core/model/x.h", "\"archive/reader.h\""},
      {"core/model/x.h", "\"base/file.h\""},
      {"core/model/x.h", "<thread>"},
      {"core/archive/x_reader.cpp", "\"archive/section_writer.h\""},
      {"core/archive/x_reader.cpp", "\"section_writer.h\""},
      {"core/archive/coding/x.cpp", "\"archive/coding/writer/choose_predictors.h\""},
      {"core/archive/x_writer.cpp", "\"bake/rig/source.h\""},
      {"core/runtime/x.cpp", "\"archive/section_writer.h\""},
      {"core/runtime/x.cpp", "\"bake/rig/source.h\""},
      {"core/runtime/x.cpp", "\"../bake/rig/source.h\""},
      {"core/bake/train/x.cpp", "\"runtime/evaluator.h\""},
      {"core/bake/rig/x.cpp", "\"bake/dataset/npy.h\""},
      {"core/bake/analysis/live/x.cpp", "\"bake/pipeline/bake.h\""},
      {"core/bake/regions/x.cpp", "\"bake/face/face_recipe.h\""},
      {"core/bake/train/x.cpp", "\"bake/face/face_recipe.h\""},
      {"core/bake/compress/x.cpp", "\"bake/measure/errors.h\""},
      {"core/bake/face/x.cpp", "\"bake/baselines/baselines.h\""},
      {"core/bake/baselines/x.cpp", "\"bake/pipeline/bake.h\""},
      {"core/bake/rig/x.cpp", "\"abi_guard.h\""},
      {"capi/runtime_api.cpp", "\"bake/rig/source.h\""},
      {"capi/runtime_api.cpp", "\"bake/authoring.h\""},
      {"capi/include/facebaker/x.h", "\"base/file.h\""},
      {"samples/hello/x.c", "\"base/file.h\""},
      {"bindings/python/x.c", "\"runtime/evaluator.h\""},
      {"packager/x.cpp", "\"support/skin.h\""},
      {"packager/x.cpp", "\"model/mesh.h\""},
      {"packager/commands/x.cpp", "\"bake/measure/errors.h\""},
      {"packager/commands/x.cpp", "\"bake/authoring.h\""},
      {"core/bake/rig/x.cpp", "\"rigs/support/skin.h\""},
  };
  for (const Planted& plant : forbidden) {
    CAPTURE(plant.path);
    CAPTURE(plant.include);
    const auto violations = violations_of(plant);
    REQUIRE(violations.size() == 1);
    CHECK(violations[0].find(std::string(plant.path) + ":2: ") == 0);
  }
}

TEST_CASE("what the law allows passes") {
  const Planted allowed[] = {
      {"core/archive/x_writer.cpp", "\"archive/reader.h\""},
      {"core/bake/measure/x.cpp", "\"runtime/evaluator.h\""},
      {"core/bake/regions/x.cpp", "\"bake/analysis/sparse_blendshapes.h\""},
      {"core/bake/face/x.cpp", "\"bake/train/trainer.h\""},
      {"core/bake/baselines/x.cpp", "\"bake/face/face_recipe.h\""},
      {"core/bake/pipeline/x.cpp", "\"bake/baselines/baselines.h\""},
      {"core/bake/rig/x.cpp", "<facebaker/facebaker.h>"},
      {"capi/bake/x.cpp", "\"bake/rig/source.h\""},
      {"core/bake/measure/x.h", "\"figures/face_figures.h\""},
      {"capi/bake/x.cpp", "\"figures/face_figures.h\""},
      {"packager/x.cpp", "\"base/file.h\""},
      {"packager/x.cpp", "\"figures/face_figures.h\""},
      {"packager/x.cpp", "<facebaker/facebaker.h>"},
      {"samples/hello/x.c", "<facebaker/facebaker.h>"},
      {"samples/hello/x.c", "\"hello.h\""},
      {"tests/bake/x.cpp", "\"runtime/evaluator.h\""},
      {"core/model/x.h", "<vector>"},
  };
  for (const Planted& plant : allowed) {
    CAPTURE(plant.path);
    CAPTURE(plant.include);
    CHECK(violations_of(plant).empty());
  }
}

TEST_CASE("circles of folders are found") {
  const auto circles = [](const char* back) {
    return checks::folder_circles({{"core/a/x.h", "#include \"b/y.h\"\n"},
                                   {"core/b/y.h", std::string("#include \"") + back + "\"\n"},
                                   {"core/b/z.h", ""},
                                   {"core/c/w.h", "#include \"a/x.h\"\n"}});
  };
  CHECK(circles("b/z.h").empty());
  REQUIRE(circles("a/x.h").size() == 1);
  CHECK(circles("a/x.h")[0] == "core/a -> core/b -> core/a");
  CHECK(circles("c/w.h")[0] == "core/a -> core/b -> core/c -> core/a");
}

TEST_CASE("namespaces follow folders") {
  const auto stray = [](const char* path, const char* text) { return checks::stray_namespaces({{path, text}}); };
  CHECK(stray("core/bake/rig/x.h", "namespace fb::bake {\n").empty());
  CHECK(stray("core/runtime/x.h", "namespace fb::runtime::avx2 {\n").empty());
  CHECK(stray("core/model/x.h", "namespace fb {\n").empty());
  CHECK(stray("tests/x.h", "namespace fb::test {\n").empty());
  CHECK(stray("core/bake/rig/x.h", "namespace fb {\n").size() == 1);
  CHECK(stray("core/archive/x.h", "// first\nnamespace fb::bake {\n")[0].find("core/archive/x.h:2: ") == 0);
  CHECK(stray("core/model/x.h", "namespace fb::model {\n").size() == 1);
}
