#include <cmath>
#include <cstdio>
#include <fstream>

#include "bake/dataset/open_source.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/sampling/sampling.h"
#include "bake_test_support.h"
#include "base/hash.h"

namespace test_rig_source {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

template <class T>
concept lends_clips = requires(T source) {
  std::forward<T>(source)->clips();
};
static_assert(lends_clips<OpenedSource&> && !lends_clips<OpenedSource>, "clips of a source that is gone");

TEST_CASE("a rig may say how many poses a call should have") {
  CHECK(open_toy().get()->preferred_block() == 0);
  CHECK(open_faulty_rig("preferred block").get()->preferred_block() == 7);
  CHECK(open_faulty_rig("huge preferred block").get()->preferred_block() == most_preferred_poses);
  CHECK(open_faulty_rig("preferred block beyond an older struct").get()->preferred_block() == 0);
}

TEST_CASE("a rig may declare a version, and its program is known by its bytes") {
  CHECK(open_toy().get()->version().empty());
  CHECK(open_faulty_rig("version").get()->version() == "12b");
  CHECK(open_faulty_rig("version beyond an older struct").get()->version().empty());
  const OpenedSource toy = open_toy(), faulty = open_faulty_rig("version");
  CHECK(toy->program_hash() == hash64(read_file(FB_TOY_RIG)));
  CHECK(faulty->program_hash() != toy->program_hash());
  CHECK(RigEvaluator(*toy).program_hash() == toy->program_hash());
}

TEST_CASE("a plugin is loaded with all it declares") {
  const auto rig = open_toy();
  CHECK(rig->live());
  CHECK(rig->thread_safe());
  CHECK(rig->schema().name == "toy");
  CHECK(rig->schema().control_count() == 6);
  CHECK(rig->schema().controls[1].minimum == -1);
  CHECK(rig->schema().controls[2].rest == 0.5f);
  CHECK(rig->schema().controls[3].group == "mouth");
  CHECK(rig->rest().vertex_count() == 50);
  CHECK(rig->rest().polygon_sizes.size() == 37);
  REQUIRE(rig->clips().size() == 2);
  CHECK(rig->clips()[1].name == "frown");
  CHECK(rig->clips()[1].split == Split::test);
  CHECK(rig->clips()[1].fps == 24);
}

TEST_CASE("frames of a clip are its controls evaluated") {
  const auto rig = open_toy();
  const std::size_t size = rig->rest().points.size();
  std::vector<float> read(3 * size), evaluated(3 * size);
  rig->read(0, 4, 3, read);
  rig->evaluate(std::span(rig->clips()[0].controls).subspan(4 * 6, 3 * 6), 3, evaluated);
  CHECK(read == evaluated);
  CHECK(read != std::vector<float>(3 * size));
  CHECK(
      contains(failure(Status::invalid_argument, [&] { rig->read(0, 10, 3, read); }), "\"talk\" has no frames 10..13"));
}

TEST_CASE("a rig may have texture coordinates, which its dataset keeps") {
  const auto rig = open_faulty_rig("texture");
  CHECK(rig->rest().uvs == std::vector<float>{0, 0, 0.5f, 0, 0.5f, 1});
  REQUIRE(rig->rest().uv_corners.size() == rig->rest().polygon_corners.size());
  CHECK(rig->rest().uv_corners[4] == 1);
  const auto older = open_faulty_rig("texture beyond an older struct");
  CHECK(older->rest().uvs.empty());
  CHECK(open_faulty_rig("texture in an older struct").get()->rest().uvs == rig->rest().uvs);
  const Folder folder;
  sample(*rig, {.poses = 40}, folder.path(), {}, silent_progress());
  const auto recorded = open_source(folder.path());
  CHECK(recorded->rest().uvs == rig->rest().uvs);
  CHECK(recorded->rest().uv_corners == rig->rest().uv_corners);
}

TEST_CASE("controls and clips of a later header are read by their stride") {
  const auto rig = open_faulty_rig("longer structs");
  const auto toy = open_toy();
  REQUIRE(rig->schema().control_count() == toy->schema().control_count());
  CHECK(rig->schema().controls[5].name == "mouthWide");
  CHECK(rig->schema().controls[2].rest == 0.5f);
  CHECK(rig->clips().at(1).name == "frown");
  CHECK(rig->clips()[1].controls == toy->clips()[1].controls);
}

TEST_CASE("a faulty rig is refused by name") {
  const struct {
    const char* fault;
    Status status;
    const char* message;
  } faults[] = {
      {"open fails", Status::rig, "the licence server is asleep"},
      {"abi", Status::unsupported, "made for rig ABI 3, this library has rig ABI 2"},
      {"older abi", Status::unsupported, "made for rig ABI 1, this library has rig ABI 2: compile it against"},
      {"struct size", Status::rig, "struct_size is 8"},
      {"control stride", Status::rig, "control_stride is 24, less than the 32 bytes of an fb_rig_control"},
      {"clip stride", Status::rig, "clip_stride is 0, less than the 40 bytes of an fb_rig_clip"},
      {"no name", Status::rig, "name is null"},
      {"no units", Status::rig, "rig \"toy\": units is empty"},
      {"up axis", Status::rig, "up_axis is \"x\""},
      {"no evaluate", Status::rig, "evaluate is null"},
      {"no controls", Status::rig, "control_count is zero"},
      {"null controls", Status::rig, "controls is null"},
      {"no vertices", Status::rig, "vertex_count is zero"},
      {"null rest", Status::rig, "rest_positions is null"},
      {"null corners", Status::rig, "polygon_corners is null"},
      {"null control name", Status::rig, "the name of control 2 is null"},
      {"double control", Status::rig, "control name \"jawOpen\" occurs twice"},
      {"range", Status::rig, "control \"browLift\": minimum 0 is not below maximum -1"},
      {"range nan", Status::rig, "control \"browLift\": its range or default is not a number"},
      {"default", Status::rig, "control \"browLift\": default 3 is outside its range 0..2"},
      {"two corners", Status::rig, "polygon 5 has 2 corners"},
      {"huge polygon", Status::rig, "polygon 5 has 1000000000 corners"},
      {"bad corner", Status::rig, "polygon 2 names vertex 50 of 50"},
      {"rest nan", Status::rig, "vertex 10 is not finite"},
      {"rest moved", Status::rig, "its rest pose is not its rest mesh: vertex 20 is 0.01"},
      {"null texture", Status::rig, "uvs is null"},
      {"texture corner", Status::rig, "corner 2 names texture coordinate 2 of 2"},
      {"null clips", Status::rig, "clips is null"},
      {"double clip", Status::rig, "clip name \"talk\" occurs twice"},
      {"clip kind", Status::rig, "clip \"frown\" is of unknown kind 5"},
      {"clip split", Status::rig, "clip \"frown\" belongs to unknown split -1"},
      {"clip fps", Status::rig, "clip \"frown\" has 0 frames a second"},
      {"clip empty", Status::rig, "clip \"frown\" has no frames"},
      {"clip null", Status::rig, "the controls of clip \"frown\" are null"},
      {"clip range", Status::rig, "clip \"frown\", frame 4: control \"jawOpen\" is 1.5, outside its range 0..1"},
      {"clip nan", Status::not_finite, "clip \"frown\", frame 4: control \"jawOpen\" is nan"},
      {"first pose only", Status::not_finite, "the rest pose cannot be evaluated"},
  };
  for (const auto& wrong : faults) {
    CAPTURE(wrong.fault);
    const std::string what = failure(wrong.status, [&] { open_faulty_rig(wrong.fault); });
    CHECK_MESSAGE(contains(what, wrong.message), what);
    CHECK_MESSAGE(contains(what, FB_FAULTY_RIG), what);
  }
}

TEST_CASE("the pose that fails in a long block is named with the rig's own message") {
  const std::size_t count = 12400, bad = 12345;
  std::vector<float> controls;
  const auto toy = open_toy();
  const std::vector<float> rest = toy->schema().rest_pose();
  for (std::size_t i = 0; i < count; ++i) controls.insert(controls.end(), rest.begin(), rest.end());
  controls[bad * 6 + 1] = -0.5f;
  std::vector<float> points(count * 150);
  const struct {
    const char* fault;
    Status status;
    const char* message;
  } faults[] = {
      {"fails on a pose", Status::rig, "pose 12345: rig \"toy\" failed: the twist solver did not converge"},
      {"fails without words", Status::rig, "pose 12345: rig \"toy\" failed: status 11 without a message"},
      {"nan on a pose", Status::not_finite, "pose 12345: rig \"toy\": vertex 17 is not finite"},
      {"fails on blocks", Status::rig, "pose 0: rig \"toy\" failed: too many poses for me (on a block of 32 poses"}};
  for (const auto& wrong : faults) {
    const auto rig = open_faulty_rig(wrong.fault);
    for (const int threads : {1, 2}) {
      RigEvaluator evaluator(*rig, {.threads = threads});
      const std::string parallel = failure(wrong.status, [&] { evaluator.evaluate(controls, count, points); });
      CHECK_MESSAGE(contains(parallel, wrong.message), parallel);
    }
    const std::string serial = failure(wrong.status, [&] { rig->evaluate(controls, count, points); });
    CHECK_MESSAGE(contains(serial, wrong.message), serial);
  }
}

TEST_CASE("whatever a rig throws is an error of the rig, which names the pose") {
  CHECK(contains(failure(Status::rig, [] { open_hostile_rig("throws when opened"); }),
                 "fb_rig_open threw an exception that has no message (C++ type PKc)"));
  const struct {
    const char *fault, *message;
  } faults[] = {{"throws a number", "pose 40: rig \"sheet\" failed: it threw an exception that has no message"},
                {"throws an exception", "pose 40: rig \"sheet\" failed: it threw an exception: the brow is missing"}};
  std::vector<float> controls(50 * 6), points(50 * 64 * 3);
  controls[40 * 6 + 2] = 1;
  for (const auto& wrong : faults) {
    const auto rig = open_hostile_rig(wrong.fault);
    for (const int threads : {1, 2}) {
      const std::string what =
          failure(Status::rig, [&] { RigEvaluator(*rig, {.threads = threads}).evaluate(controls, 50, points); });
      CHECK_MESSAGE(contains(what, wrong.message), what);
    }
  }
  open_hostile_rig("throws when destroyed").reset();
}

TEST_CASE("points further than 10,000 diagonals from rest are refused with pose, vertex and value") {
  const auto rig = open_hostile_rig("far vertex");
  std::vector<float> controls(2 * 6), points(2 * 64 * 3);
  controls[6 + 1] = 1;
  const std::string what = failure(Status::bad_data, [&] { rig->evaluate(controls, 2, points); });
  CHECK_MESSAGE(contains(what, "pose 1: rig \"sheet\": vertex 17 x = 1e+10 is more than 10000 diagonals"), what);
  const auto huge = open_hostile_rig("huge points");
  controls[3] = 1;
  CHECK(contains(failure(Status::bad_data, [&] { huge->evaluate(controls, 2, points); }), "vertex 0 x = 3e+38"));
}

TEST_CASE("a rig may have no polygons: it is a set of points") {
  for (const auto& rig : {open_faulty_rig("no polygons"), open_hostile_rig("no polygons")}) {
    CHECK(rig->rest().polygon_sizes.empty());
    CHECK(rig->rest().polygon_corners.empty());
  }
}

TEST_CASE("a rig that is not thread-safe is called by one thread only, with the same result") {
  const auto one = open_faulty_rig("one thread only");
  const auto toy = open_toy();
  CHECK_FALSE(one->thread_safe());
  std::vector<float> controls;
  for (int i = 0; i < 500; ++i) controls.insert(controls.end(), {0.1f, -0.2f, 1.0f, float(i) / 500, 0.4f, 0.0f});
  std::vector<float> a(500 * 150), b(500 * 150);
  RigEvaluator(*one, {.threads = 4}).evaluate(controls, 500, a);
  RigEvaluator(*toy, {.threads = 4}).evaluate(controls, 500, b);
  CHECK(a == b);
}

TEST_CASE("values outside the range never reach a rig") {
  const auto rig = open_toy();
  std::vector<float> controls(2 * 6, 0.5f), points(2 * 150);
  controls[6 + 3] = 1.01f;
  CHECK(contains(failure(Status::invalid_argument, [&] { rig->evaluate(controls, 2, points); }),
                 "pose 1: control \"jawOpen\" is 1.01, outside its range 0..1"));
  controls[6 + 3] = NAN;
  failure(Status::invalid_argument, [&] { rig->evaluate(controls, 2, points); });
  CHECK(contains(failure(Status::invalid_argument, [&] { rig->evaluate(controls, 3, points); }), "18 control values"));
}

TEST_CASE("what is no source is refused") {
  const Folder folder;
  CHECK(contains(failure(Status::not_found, [] { open_source("/nowhere/at/all"); }), "/nowhere/at/all: no such file"));
  CHECK(contains(failure(Status::not_found, [&] { open_source(folder.path()); }), "holds no dataset.json"));
  std::ofstream(folder / "face.so") << "not a library";
  CHECK(contains(failure(Status::rig, [&] { open_source(folder / "face.so"); }), "cannot be loaded as a rig plugin"));
  std::ofstream(folder / "face.glb") << "glTF";
  CHECK(contains(failure(Status::bad_data, [&] { open_source(folder / "face.glb"); }), "is no whole glTF file"));
  std::ofstream(folder / "face.txt") << "?";
  failure(Status::invalid_argument, [&] { open_source(folder / "face.txt"); });
  failure(Status::invalid_argument, [] { open_sources({}); });
}

TEST_CASE("the sample face is looked for in FACEBAKER_RIG_PATH first") {
  const Folder folder;
  std::filesystem::copy_file(FB_TOY_RIG, folder / "librig_sample.so");
  setenv("FACEBAKER_RIG_PATH", ("/nowhere:" + folder.path().string()).c_str(), 1);
  const auto found = open_source("sample");
  CHECK(found->schema().name == "toy");
  unsetenv("FACEBAKER_RIG_PATH");
}

TEST_CASE("two sources of one rig are one rig, and a clip of both is kept once") {
  const auto both = open_sources({FB_TOY_RIG, FB_TOY_RIG});
  CHECK(both->live());
  CHECK(both->thread_safe());
  CHECK(both->clips().size() == 2);
  CHECK(both->notes().size() == 2);
  std::vector<float> points(150);
  both->read(1, 3, 1, points);
  both->evaluate(both->schema().rest_pose(), 1, points);
  CHECK(std::abs(points[0] - both->rest().points[0]) < 1e-6f);
}

}  // namespace test_rig_source
