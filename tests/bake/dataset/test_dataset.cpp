#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>

#include "bake/dataset/npy.h"
#include "bake/dataset/open_source.h"
#include "bake_test_support.h"
#include "toy_dataset.h"

namespace test_dataset {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using namespace fb::test::toy_dataset;

TEST_CASE("a dataset written by hand is read") {
  const ToyDataset toy;
  const auto source = toy.open();
  CHECK_FALSE(source->live());
  CHECK(source->thread_safe());
  REQUIRE(source->notes().size() == 1);
  CHECK(source->notes()[0] ==
        "6 of 18 poses, those of \"later\", are left out: they have no points, or not those of all frames");
  CHECK(source->schema().name == "hand");
  CHECK(source->schema().units == "m");
  CHECK(source->schema().up_axis == "z");
  CHECK(source->schema().controls[0].group == "mouth");
  CHECK(source->schema().controls[0].rest == 0.25f);
  CHECK(source->schema().controls[1].minimum == -0.5f);
  CHECK(source->rest().polygon_sizes == std::vector<std::uint32_t>{4, 3});
  CHECK(source->rest().polygon_corners == std::vector<std::uint32_t>{0, 1, 2, 3, 2, 1, 0});
  REQUIRE(source->clips().size() == 3);
  const Clip& talk = source->clips()[0];
  CHECK(talk.kind == ClipKind::regional);
  CHECK(talk.split == Split::validation);
  CHECK(talk.fps == 24);
  CHECK(talk.frames == frames);
  CHECK(talk.controls[3] == 0.12f);
  CHECK(source->clips()[1].kind == ClipKind::shot);
  CHECK(source->clips()[2].split == Split::train);
  std::vector<float> points(2 * 12);
  source->read(0, 3, 2, points);
  CHECK(points[0] == 18);
  CHECK(points[23] == 29.5f);
  CHECK(source->readable(1));
  CHECK_FALSE(source->readable(2));
  CHECK(contains(failure(Status::invalid_argument, [&] { source->read(2, 0, 2, points); }),
                 toy.folder.path().string() + ": clip \"later\" is a plan"));
  failure(Status::invalid_argument, [&] { source->read(0, 5, 2, points); });
  failure(Status::invalid_argument, [&] { source->evaluate(source->schema().rest_pose(), 1, points); });
}

TEST_CASE("points may be in shards, named or numbered") {
  ToyDataset toy;
  const std::vector<float> all = counting(frames * 12, 0.5f);
  std::filesystem::remove(toy.folder / "talk.points.npy");
  write_npy(toy.folder / "talk.000.points.npy", {4, vertices, 3}, std::span(all).first(48));
  write_npy(toy.folder / "talk.001.points.npy", {2, vertices, 3}, std::span(all).subspan(48));
  const std::vector<float> some = counting(frames * controls, 0.04f);
  std::filesystem::remove(toy.folder / "talk.controls.npy");
  write_npy(toy.folder / "talk.000.controls.npy", {frames, controls}, some);
  for (const bool named : {false, true}) {
    if (named) toy.replace("\"talk.points.npy\"", "[\"talk.000.points.npy\", \"talk.001.points.npy\"]");
    const auto source = toy.open();
    std::vector<float> points(frames * 12), middle(3 * 12);
    source->read(0, 0, frames, points);
    CHECK(points == all);
    source->read(0, 2, 3, middle);
    CHECK(middle == std::vector<float>(all.begin() + 24, all.begin() + 60));
  }
  std::filesystem::remove(toy.folder / "talk.001.points.npy");
  CHECK(contains(failure(Status::not_found, [&] { toy.open(); }), "talk.001.points.npy)"));
}

TEST_CASE("ambiguous shards are refused") {
  const ToyDataset toy;
  const std::vector<float> two = counting(2 * 12, 0.5f);
  write_npy(toy.folder / "talk.000.points.npy", {2, vertices, 3}, two);
  CHECK(contains(failure(Status::bad_data, [&] { toy.open(); }),
                 "talk.points.npy: is there whole and in shards, such as talk.000.points.npy"));
  std::filesystem::remove(toy.folder / "talk.points.npy");
  write_npy(toy.folder / "talk.002.points.npy", {2, vertices, 3}, two);
  CHECK(contains(failure(Status::not_found, [&] { toy.open(); }),
                 "talk.001.points.npy: no such file, but the next shard is there"));
}

TEST_CASE("the rest mesh may be a mesh file") {
  ToyDataset toy;
  toy.replace(R"({ "points": "rest.npy", "faces": "faces.npy" })", "\"rest.obj\"");
  std::ofstream obj(toy.folder / "rest.obj");
  obj << "# a comment\nmtllib x\nv 0 0 0\nv 1 0 0 1.0\r\nvn 0 0 1\nvt 0 0\nvt 1 1\nv 1 1 0\n f 1/2/3 2//1 3\nv 0 1 "
         "0\nf -4 -2 -1";
  obj.close();
  const auto source = toy.open();
  CHECK(source->rest().vertex_count() == 4);
  CHECK(source->rest().points[10] == 1);
  CHECK(source->rest().polygon_corners == std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3});
  const struct {
    const char *text, *message;
  } bad[] = {{"v 1 2", "line 1: a vertex needs three numbers"},
             {"v 1 2 x", "line 1: a vertex needs three numbers"},
             {"v 0 0 0\nf 1 1 2", "line 2: vertex 2, but 1 came before"},
             {"v 0 0 0\nf 1 1 0", "line 2: vertex 0"},
             {"v 0 0 0\nf 1 1 -2", "line 2: vertex -2"},
             {"v 0 0 0\nf 1 1", "line 2: a face of 2 corners"},
             {"v 0 0 0\nf 1 1 a", "line 2: \"a\" is no corner"},
             {"", "not a positive multiple of 3"}};
  for (const auto& wrong : bad) {
    CAPTURE(wrong.text);
    std::ofstream(toy.folder / "rest.obj") << wrong.text;
    const std::string what = failure(Status::bad_data, [&] { toy.open(); });
    CHECK_MESSAGE(contains(what, wrong.message), what);
  }
}

TEST_CASE("texture coordinates of an .obj are kept if every corner has them") {
  ToyDataset toy;
  toy.replace(R"({ "points": "rest.npy", "faces": "faces.npy" })", "\"rest.obj\"");
  const std::string head = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt .5 .25\n";
  const auto open_with = [&](const std::string& faces) {
    std::ofstream(toy.folder / "rest.obj") << head << faces;
    return toy.open();
  };
  const auto source = open_with("f 1/1 2/-2/7 3/3\nf 1/1 3/2 4/3");
  CHECK(source->rest().uvs == std::vector<float>{0, 0, 1, 0, .5f, .25f});
  CHECK(source->rest().uv_corners == std::vector<std::uint32_t>{0, 1, 2, 0, 1, 2});
  CHECK(source->rest().polygon_corners == std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3});
  const auto partly = open_with("f 1/1 2/2 3/3\nf 1 3 4");
  CHECK(partly->rest().uvs.empty());
  CHECK(contains(failure(Status::bad_data, [&] { open_with("f 1/1 2/4 3/3"); }),
                 "line 8: texture coordinate 4, but 3 came before"));
  CHECK(contains(failure(Status::bad_data, [&] { open_with("f 1/1 2/x 3/3"); }), "line 8: \"x\" is no corner"));
  CHECK(contains(failure(Status::bad_data, [&] { open_with("vt 1\n"); }), "a texture coordinate needs two numbers"));
}

TEST_CASE("texture coordinates may be two more arrays") {
  ToyDataset toy;
  toy.replace(R"("faces": "faces.npy" })", R"("faces": "faces.npy", "uvs": "uvs.npy", "uv_faces": "uv_faces.npy" })");
  const std::vector<float> uvs = counting(5 * 2, 0.1f);
  write_npy(toy.folder / "uvs.npy", {5, 2}, uvs);
  const auto with_faces = [&](const std::vector<std::size_t>& shape, const std::vector<std::int32_t>& faces) {
    write_npy(toy.folder / "uv_faces.npy", shape, faces);
    return toy.open();
  };
  const auto source = with_faces({2, 4}, {0, 1, 2, 3, 4, 1, 0, -1});
  CHECK(source->rest().uvs == uvs);
  CHECK(source->rest().uv_corners == std::vector<std::uint32_t>{0, 1, 2, 3, 4, 1, 0});
  CHECK(contains(failure(Status::bad_data,
                         [&] {
                           with_faces({1, 4}, {0, 1, 2, 3});
                         }),
                 "uv_faces.npy: its faces are not those of faces.npy"));
  CHECK(contains(failure(Status::bad_data,
                         [&] {
                           with_faces({2, 4}, {0, 1, 2, 3, 5, 1, 0, -1});
                         }),
                 "names texture coordinate 5 of 5"));
  write_npy(toy.folder / "uvs.npy", {2, 5}, uvs);
  CHECK(contains(failure(Status::bad_data, [&] { toy.open(); }), "uvs.npy: shape (2, 5)"));
}

TEST_CASE("the rest mesh may be a glTF binary") {
  ToyDataset toy;
  toy.replace(R"({ "points": "rest.npy", "faces": "faces.npy" })", "\"rest.glb\"");
  const float points[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const std::uint16_t corners[6] = {0, 1, 2, 0, 2, 3};
  const auto write_glb = [&](const std::string& count) {
    std::string json = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":60}],"bufferViews":[
      {"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],"accessors":[
      {"bufferView":0,"componentType":5126,"count":)" +
                       count + R"(,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
      {"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}]})";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto word = [](std::size_t n) {
      const auto u = static_cast<std::uint32_t>(n);
      return std::string(reinterpret_cast<const char*>(&u), 4);
    };
    std::string glb = "glTF" + word(2) + word(12 + 8 + json.size() + 8 + 60) + word(json.size()) + "JSON" + json;
    glb += word(60) + std::string("BIN\0", 4) + std::string(reinterpret_cast<const char*>(points), 48) +
           std::string(reinterpret_cast<const char*>(corners), 12);
    std::ofstream(toy.folder / "rest.glb", std::ios::binary) << glb;
  };
  write_glb("4");
  const auto source = toy.open();
  CHECK(source->rest().points == std::vector<float>(points, points + 12));
  CHECK(source->rest().polygon_corners == std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3});
  write_glb("4000000");
  CHECK(contains(failure(Status::bad_data, [&] { toy.open(); }), "rest.glb"));
  std::ofstream(toy.folder / "rest.glb") << "not a mesh";
  CHECK(contains(failure(Status::bad_data, [&] { toy.open(); }), "rest.glb"));
}

TEST_CASE("fields of dataset.json are checked by name") {
  const std::string deep = std::string(20000, '[') + std::string(20000, ']');
  const struct {
    const char *from, *to, *message;
    Status status = Status::bad_data;
  } spoiled[] = {
      {"facebaker-dataset", "other", "its \"format\" is not \"facebaker-dataset\""},
      {"\"version\": 1", "\"version\": 2", "version is 2; this program reads 1", Status::unsupported},
      {"\"version\": 1", "\"version\": \"1\"", "version is no number"},
      {"\"version\": 1,", "", "version is missing"},
      {"\"name\": \"hand\",", "", "name is missing"},
      {"\"units\": \"m\"", "\"units\": 3", "units is no string"},
      {"\"up_axis\": \"z\"", "\"up_axis\": \"x\"", "up_axis is neither"},
      {"\"points\": \"rest.npy\",", "", "rest points is missing"},
      {"\"min\": 0,", "", "controls[0] min is missing"},
      {"\"max\": 1", "\"max\": null", "controls[0] max is no number"},
      {"\"max\": 1", "\"max\": 1e39", "controls[0] max is too large"},
      {"\"max\": 1", "\"max\": 1e999", "is no JSON"},
      {"\"max\": 1", "\"max\": 0", "control \"open\": minimum 0 is not below maximum 0"},
      {"\"default\": 0.25", "\"default\": 2", "control \"open\": default 2 is outside"},
      {"\"name\": \"turn\"", "\"name\": \"open\"", "control name \"open\" occurs twice"},
      {"\"name\": \"turn\"", "\"name\": \"\"", "controls[1] name is empty"},
      {"\"kind\": \"regional\"", "\"kind\": \"dance\"", "clips[0] kind \"dance\" is no kind of clip; there are shot"},
      {"\"split\": \"test\"", "\"split\": \"exam\"", "clips[1] split \"exam\" is no split"},
      {"\"fps\": 24", "\"fps\": 0", "clips[0] fps is not above zero"},
      {"\"name\": \"walk\"", "\"name\": \"talk\"", "clips[1] name \"talk\" occurs twice"},
      {", \"points\": \"walk.points.npy\"", ", \"points\": []", "clips[1] points is empty"},
      {"\"controls\": \"later.controls.npy\"", "\"points\": \"p.npy\"", "clips[2] controls is missing"},
      {"\"clips\": [", "\"clips\": 5, \"x\": [", "clips is no list"},
      {"}", "", "is no JSON"},
      {"\"unknown fields are ignored\"", deep.c_str(), "lies more than 64 objects and arrays deep"},
      {"\"rest.npy\"", "\"../rest.npy\"", "names \"../rest.npy\", which does not lie in its folder"},
      {"\"faces.npy\"", "\"/dev/null\"", "names \"/dev/null\", which does not lie in its folder"},
      {"{ \"points\": \"rest.npy\", \"faces\": \"faces.npy\" }", "\"sub/../../rest.obj\"",
       "does not lie in its folder"},
      {"\"talk.points.npy\"", "\"sub/../../talk.points.npy\"", "does not lie in its folder"},
      {"\"talk.controls.npy\"", "[\"talk.controls.npy\", \"../more.npy\"]", "names \"../more.npy\""},
      {"rest.npy", "none.npy", "none.npy)", Status::not_found},
      {"\"talk.points.npy\"", "\"none.points.npy\"", "none.points.npy: no such file, and no shard none.000.points.npy",
       Status::not_found},
  };
  for (const auto& wrong : spoiled) {
    CAPTURE(wrong.from);
    ToyDataset toy;
    toy.replace(wrong.from, wrong.to);
    const std::string what = failure(wrong.status, [&] { toy.open(); });
    CHECK_MESSAGE(contains(what, wrong.message), what);
    CHECK_MESSAGE(contains(what, toy.folder.path()), what);
    CHECK_MESSAGE(!contains(what, "::"), what);
    CHECK_MESSAGE(!contains(what, "exception"), what);
  }
}

TEST_CASE("files of a dataset may lie in folders of it, and links may not lead out") {
  ToyDataset toy;
  const Folder elsewhere;
  std::filesystem::create_directory(toy.folder / "sub");
  std::filesystem::rename(toy.folder / "talk.points.npy", toy.folder / "sub/talk.points.npy");
  toy.replace("talk.points.npy", "sub/../sub/talk.points.npy");
  toy.open();
  std::filesystem::create_symlink("sub", toy.folder / "inside");
  toy.replace("sub/../sub/talk.points.npy", "inside/talk.points.npy");
  toy.open();
  std::filesystem::rename(toy.folder / "walk.points.npy", elsewhere / "walk.points.npy");
  std::filesystem::create_symlink(elsewhere / "walk.points.npy", toy.folder / "walk.000.points.npy");
  CHECK(contains(failure(Status::bad_data, [&] { toy.open(); }),
                 "names \"walk.000.points.npy\", which does not lie in its folder"));
}

TEST_CASE("a dataset follows the rules of all sources: no group, no polygons, limits of coordinates") {
  ToyDataset toy;
  toy.replace("\"group\": \"mouth\"", "\"group\": \"\"");
  write_npy(toy.folder / "faces.npy", {0, 3}, std::vector<std::int32_t>{});
  const auto source = toy.open();
  CHECK(source->schema().controls[0].group.empty());
  CHECK(source->rest().polygon_sizes.empty());

  std::vector<float> points = counting(frames * vertices * 3, 0.5f);
  points[2 * vertices * 3 + 4] = -1e30f;
  write_npy(toy.folder / "talk.points.npy", {frames, vertices, 3}, points);
  std::vector<float> read(frames * vertices * 3);
  const auto far = toy.open();
  const std::string what = failure(Status::bad_data, [&] { far->read(0, 0, frames, read); });
  CHECK_MESSAGE(contains(what, "talk.points.npy: clip \"talk\", frame 2: vertex 1 y = -1e+30 is more than 10000"),
                what);

  for (const bool tiny : {true, false}) {
    const float side = tiny ? 1e-26f : 1e26f;
    write_npy(toy.folder / "rest.npy", {vertices, 3},
              std::vector<float>{0, 0, 0, side, 0, 0, side, side, 0, 0, side, 0});
    const std::string refused = failure(Status::bad_data, [&] { toy.open(); });
    CHECK_MESSAGE(contains(refused, tiny ? "its diagonal is" : "vertex 1 x = 1e+26"), refused);
    CHECK_MESSAGE(contains(refused, "dataset.json: rest mesh: "), refused);
  }
}

TEST_CASE("every prefix of dataset.json is refused") {
  ToyDataset toy;
  const std::string whole = toy.json;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    toy.json = whole.substr(0, length);
    failure(Status::bad_data, [&] { toy.open(); });
  }
}

TEST_CASE("arrays that do not fit are refused by file") {
  using Spoil = std::function<void(const Folder&)>;
  const float nan = NAN;
  const struct {
    Spoil spoil;
    const char* message;
    Status status = Status::bad_data;
  } spoiled[] = {
      {[](const Folder& f) {
         write_npy(f / "talk.points.npy", {frames, 5, 3}, std::vector<float>(frames * 15));
       },
       "talk.points.npy: shape (6, 5, 3) where (frames, 4, 3) is needed"},
      {[](const Folder& f) {
         write_npy(f / "talk.points.npy", {frames, 12}, std::vector<float>(frames * 12));
       },
       "talk.points.npy: shape (6, 12) where (frames, 4, 3) is needed"},
      {[](const Folder& f) {
         write_npy(f / "talk.points.npy", {5, vertices, 3}, std::vector<float>(60));
       },
       "clip \"talk\" has 6 frames of controls and 5 frames of points"},
      {[](const Folder& f) {
         write_npy(f / "talk.controls.npy", {frames, 1}, std::vector<float>(frames));
       },
       "talk.controls.npy: shape (6, 1) where (frames, 2) is needed"},
      {[](const Folder& f) {
         write_npy(f / "later.controls.npy", {0, 2}, std::vector<float>());
       },
       "later.controls.npy: has no frames"},
      {[&](const Folder& f) {
         std::vector<float> values(frames * controls);
         values[7] = nan;
         write_npy(f / "talk.controls.npy", {frames, controls}, values);
       },
       "talk.controls.npy: clip \"talk\", frame 3: control \"turn\" is not finite", Status::not_finite},
      {[](const Folder& f) { write_npy(f / "rest.npy", {12}, std::vector<float>(12)); }, "(vertices, 3) is needed"},
      {[&](const Folder& f) {
         write_npy(f / "rest.npy", {2, 3}, std::vector<float>{0, 0, 0, 0, nan, 0});
       },
       "vertex 1 is not finite", Status::not_finite},
      {[](const Folder& f) {
         write_npy(f / "faces.npy", {1, 3}, std::vector<std::int32_t>{0, 1, 4});
       },
       "polygon 0 names vertex 4 of 4"},
      {[](const Folder& f) {
         write_npy(f / "faces.npy", {1, 4}, std::vector<std::int32_t>{0, 1, -1, 2});
       },
       "faces.npy: face 0 goes on after a -1"},
      {[](const Folder& f) {
         write_npy(f / "faces.npy", {1, 3}, std::vector<std::int32_t>{0, 1, -1});
       },
       "polygon 0 has 2 corners"},
      {[](const Folder& f) {
         write_npy(f / "faces.npy", {1, 3}, std::vector<std::int32_t>{0, 1, -2});
       },
       "faces.npy: face 0 names vertex -2"},
      {[](const Folder& f) {
         write_npy(f / "faces.npy", {1, 3}, std::vector<float>{0, 1, 2});
       },
       "faces.npy: holds floats where integers are needed"},
      {[](const Folder& f) { std::filesystem::resize_file(f / "walk.points.npy", 300); },
       "walk.points.npy: is truncated: shape (6, 4, 3)"},
      {[](const Folder& f) { std::filesystem::remove(f / "later.controls.npy"); }, "later.controls.npy: no such file",
       Status::not_found},
  };
  for (const auto& wrong : spoiled) {
    CAPTURE(wrong.message);
    const ToyDataset toy;
    wrong.spoil(toy.folder);
    const std::string what = failure(wrong.status, [&] { toy.open(); });
    CHECK_MESSAGE(contains(what, wrong.message), what);
  }
}

TEST_CASE("a point that is not finite is named by file, frame and vertex when it is read") {
  const ToyDataset toy;
  std::vector<float> points = counting(frames * 12, 0.5f);
  points[4 * 12 + 7] = INFINITY;
  write_npy(toy.folder / "walk.points.npy", {frames, vertices, 3}, points);
  const auto source = toy.open();
  std::vector<float> read(4 * 12);
  source->read(1, 0, 4, read);
  CHECK(contains(failure(Status::not_finite, [&] { source->read(1, 2, 4, read); }),
                 "walk.points.npy: clip \"walk\", frame 4: vertex 2 is not finite"));
}

TEST_CASE("recorded values outside their range are kept and noted") {
  const ToyDataset toy;
  std::vector<float> values(frames * controls);
  values[5] = -0.75f;
  values[8] = 1.125f;
  write_npy(toy.folder / "walk.controls.npy", {frames, controls}, values);
  const auto source = toy.open();
  CHECK(source->clips()[1].controls == values);
  REQUIRE(source->notes().size() == 2);
  CHECK(source->notes()[0] ==
        "clip \"walk\": 2 control values are outside their range and kept, at worst \"turn\" = -0.75 (-0.5..0.5) in "
        "frame 2");
}

TEST_CASE("datasets of one character are read as one") {
  const ToyDataset a;
  ToyDataset b;
  write_npy(b.folder / "talk.controls.npy", {frames, controls}, std::vector<float>(frames * controls));
  a.open();
  b.open();
  const std::vector<std::string> folders = {a.folder.path(), b.folder.path()};
  const auto both = open_sources(folders);
  std::vector<std::string> names;
  for (const Clip& clip : both->clips()) names.push_back(clip.name);
  CHECK(names == std::vector<std::string>{"talk", "walk", "later", "talk (2)"});
  CHECK(both->notes().size() == 5);
  std::vector<float> points(12);
  both->read(3, 1, 1, points);
  CHECK(points[0] == 6);
  b.replace("\"test\"", "\"train\"");
  b.open();
  CHECK(contains(failure(Status::bad_data, [&] { open_sources(folders); }),
                 "clip \"walk\" is of split train, but the same clip \"walk\" is of split test elsewhere"));
  b.replace("\"train\"", "\"test\"");
  CHECK(contains(failure(Status::bad_data, [&] { open_sources({a.folder.path(), FB_TOY_RIG}); }), "2 controls"));
  b.replace("\"max\": 0.5", "\"max\": 0.75");
  b.open();
  CHECK(contains(failure(Status::bad_data, [&] { open_sources(folders); }), "control \"turn\" has another range"));
  b.replace("\"max\": 0.75", "\"max\": 0.5");
  write_npy(b.folder / "rest.npy", {vertices, 3}, std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5f});
  b.open();
  CHECK(contains(failure(Status::bad_data, [&] { open_sources(folders); }), "vertex 3 is elsewhere"));
}

}  // namespace test_dataset
