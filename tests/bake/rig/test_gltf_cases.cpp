// Files that went wrong once, in tests/fixtures/cases: what each gives.
#include <algorithm>
#include <array>
#include <filesystem>

#include "bake_test_support.h"
#include "signed_volume.h"

namespace test_gltf_cases {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

OpenedSource open_case(const std::string& name) {
  return open_source((std::filesystem::path(FB_CASES) / name).string());
}

std::vector<std::string> control_names(const Source& rig) {
  std::vector<std::string> names;
  for (const Control& control : rig.schema().controls) names.push_back(control.name);
  return names;
}

bool notes_have(const Source& rig, const std::string& words) {
  return std::ranges::any_of(rig.notes(), [&](const std::string& note) { return contains(note, words); });
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("faces of mirrored nodes point outwards") {
  for (const char* file : {"mirror.glb", "head_mirrored.glb", "two_scenes.glb"}) {
    const auto rig = open_case(file);
    for (const double volume : signed_volumes(rig->rest())) {
      CAPTURE(std::string(file));
      CHECK(volume > 0);
    }
  }
  CHECK(signed_volumes((*open_case("mirror.glb")).rest()).size() == 3);
}

TEST_CASE("names of targets that are repeated, missing or the same are told apart") {
  const auto twice = open_case("names_twice.glb");
  CHECK(control_names(*twice) == Names{"jawOpen", "mouthSmile"});
  const auto same = open_case("same_target_name.glb");
  CHECK(control_names(*same) == Names{"jawOpen", "jawOpen 2"});
  CHECK(notes_have(*same, "one name are told apart by numbers: \"jawOpen 2\""));
  const auto blank = open_case("blank_target_name.glb");
  CHECK(control_names(*blank) == Names{"Face target 0", "mouthSmile"});
  CHECK(notes_have(*blank, "without a name are controls by their numbers: \"Face target 0\""));
}

TEST_CASE("a primitive without the targets of another does not move") {
  const auto rig = open_case("mixed_primitives.glb");
  CHECK(control_names(*rig) == Names{"jawOpen", "mouthSmile"});
  CHECK(notes_have(*rig, "fewer morph targets than others of their mesh, and do not move by the rest: \"face\""));
  std::vector<float> points(rig->rest().points.size());
  rig->evaluate(std::array{1.0f, 1.0f}, 1, points);
  const std::vector<float>& rest = rig->rest().points;
  const std::size_t moving = (*open_case("blank_target_name.glb")).rest().points.size();  // the first primitive alone
  REQUIRE(points.size() > moving);
  CHECK(!std::equal(points.begin(), points.begin() + std::ptrdiff_t(moving), rest.begin()));
  CHECK(std::equal(points.begin() + std::ptrdiff_t(moving), points.end(), rest.begin() + std::ptrdiff_t(moving)));
}

TEST_CASE("of keys at one time the last counts, and weights of what has none are left out") {
  const auto cut = open_case("repeated_key_times.glb");
  REQUIRE(cut->clips().size() == 2);
  CHECK(cut->clips()[0].name == "cut");
  CHECK(cut->clips()[1].name == "good");
  CHECK(notes_have(*cut, "of several keys at one time the last counts from there on: \"cut\""));
  const auto no_mesh = open_case("weights_no_mesh.glb");
  CHECK(no_mesh->clips().empty());
  CHECK(notes_have(*no_mesh, "weights that no shown mesh has are left out: \"nomesh\""));
}

TEST_CASE("one instance and the default scene are read, and the notes say so") {
  const auto instances = open_case("instances.glb");
  CHECK(notes_have(*instances, "the first instance is read, and others are left out: \"Face\""));
  CHECK(instances->rest().points.size() == (*open_case("blank_target_name.glb")).rest().points.size());
  const auto scenes = open_case("two_scenes.glb");
  CHECK(control_names(*scenes) == Names{"jawOpen", "mouthSmile"});
  CHECK(notes_have(*scenes, "scenes besides the default one are left out: \"night\""));
  CHECK(notes_have(*scenes, "meshes that the default scene does not show are left out: \"Fangs\""));
}

TEST_CASE("a plus sign in a URI is a plus sign") {
  CHECK(control_names(*open_case("plus_in_uri.gltf")) == Names{"jawOpen", "mouthSmile"});
}

}  // namespace test_gltf_cases
