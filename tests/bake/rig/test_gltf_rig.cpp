#include <cmath>
#include <cstring>
#include <fstream>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/pipeline/bake.h"
#include "bake/rig/gltf/key_frames.h"
#include "bake_test_support.h"
#include "base/random.h"
#include "runtime/evaluator.h"

namespace test_gltf_rig {

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;
using namespace fb::runtime;
using namespace fb::test;

namespace {

// A face of two primitives, a square and a triangle, with the targets jaw (all vertices) and brow (vertex 2 alone,
// stored sparsely), placed by a node within a node, and animated with keys of both kinds.
class ToyGltf {
 public:
  ToyGltf() {
    put(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});                   // 0: the square
    put(std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3});                             // 48
    put(std::vector<float>{2, 0, 0, 3, 0, 0, 2, 1, 1});                            // 60: the triangle
    put(std::vector<std::uint16_t>{0, 1, 2, 0});                                   // 96
    put(std::vector<float>{0, -.5f, 0, 0, -.5f, .5f, 0, -.5f, 1, 0, -.5f, 1.5f});  // 104: the jaw moves the square
    put(std::vector<float>{.25f, 0, 0, .25f, 0, 0, .25f, 0, 0});                   // 152: and the triangle
    put(std::vector<std::uint16_t>{2, 0});                                         // 188: the brow moves vertex 2
    put(std::vector<float>{0, 1, 0});                                              // 192
    put(std::vector<float>{0, .1f, .2f});                                          // 204: key times
    put(std::vector<float>{0, 0, 1, .5f, .5f, 1.5f});                              // 216: key weights
    json = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":240}],
"bufferViews":[{"buffer":0,"byteLength":240}],
"accessors":[
{"bufferView":0,"byteOffset":0,"componentType":5126,"count":4,"type":"VEC3"},
{"bufferView":0,"byteOffset":48,"componentType":5123,"count":6,"type":"SCALAR"},
{"bufferView":0,"byteOffset":60,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":0,"byteOffset":96,"componentType":5123,"count":3,"type":"SCALAR"},
{"bufferView":0,"byteOffset":104,"componentType":5126,"count":4,"type":"VEC3"},
{"bufferView":0,"byteOffset":152,"componentType":5126,"count":3,"type":"VEC3"},
{"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":1,
"indices":{"bufferView":0,"byteOffset":188,"componentType":5123},"values":{"bufferView":0,"byteOffset":192}}},
{"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":0,"byteOffset":204,"componentType":5126,"count":3,"type":"SCALAR"},
{"bufferView":0,"byteOffset":216,"componentType":5126,"count":6,"type":"SCALAR"}],
"meshes":[{"name":"teeth","primitives":[{"attributes":{"POSITION":2},"indices":3}]},
{"name":"toy","extras":{"targetNames":["jaw","brow"]},"primitives":[
{"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":4},{"POSITION":6}]},
{"attributes":{"POSITION":2},"indices":3,"targets":[{"POSITION":5},{"POSITION":7}]}]}],
"skins":[{"joints":[0]}],
"nodes":[{"name":"head","rotation":[0,0,0.70710678118654752,0.70710678118654752],"children":[1]},
{"name":"face","mesh":1,"translation":[1,0,0],"scale":[2,2,2]},{"name":"mouth"}],
"animations":[
{"name":"talk","samplers":[{"input":8,"output":9,"interpolation":"LINEAR"}],
"channels":[{"sampler":0,"target":{"node":1,"path":"weights"}}]},
{"name":"talk","samplers":[{"input":8,"output":9,"interpolation":"STEP"}],
"channels":[{"sampler":0,"target":{"node":1,"path":"weights"}}]}]})";
  }

  ToyGltf& replace(const std::string& from, const std::string& to) {
    const std::size_t at = json.find(from);
    REQUIRE_MESSAGE(at != std::string::npos, from);
    json.replace(at, from.size(), to);
    return *this;
  }

  void set(std::size_t offset, float value) { std::memcpy(&buffer[offset], &value, sizeof value); }

  std::string bytes() const {
    std::string text = json;
    text.resize((text.size() + 3) / 4 * 4, ' ');
    return "glTF" + word(2) + word(20 + text.size() + 8 + buffer.size()) + word(text.size()) + "JSON" + text +
           word(buffer.size()) + std::string("BIN\0", 4) + buffer;
  }

  OpenedSource open(const std::string& name = "toy.glb") const { return open_bytes(bytes(), name); }
  OpenedSource open_bytes(const std::string& bytes, const std::string& name = "toy.glb") const {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return open_source(folder / name);
  }

  Folder folder;
  std::string json, buffer;

 private:
  template <class T>
  void put(const std::vector<T>& values) {
    buffer.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  static std::string word(std::size_t n) {
    const auto u = static_cast<std::uint32_t>(n);
    return std::string(reinterpret_cast<const char*>(&u), 4);
  }
};

std::vector<float> points_at(Source& rig, const std::vector<float>& weights) {
  std::vector<float> points(rig.rest().points.size());
  rig.evaluate(weights, 1, points);
  return points;
}

void check_close(const std::vector<float>& points, const std::vector<float>& expected) {
  REQUIRE(points.size() == expected.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    CAPTURE(i);
    CHECK(points[i] == doctest::Approx(expected[i]).epsilon(1e-6));
  }
}

// The node doubles and shifts by x = 1, the node above turns x to y and y to -x.
std::vector<float> placed(const std::vector<float>& points) {
  std::vector<float> result;
  for (std::size_t i = 0; i < points.size(); i += 3)
    result.insert(result.end(), {-2 * points[i + 1], 2 * points[i] + 1, 2 * points[i + 2]});
  return result;
}

const std::vector<float> rest_points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0, 0, 3, 0, 0, 2, 1, 1};

}  // namespace

TEST_CASE("morph targets are controls, and points are weighted sums where the nodes put them") {
  const auto rig = ToyGltf().open();
  CHECK(rig->live());
  CHECK(rig->thread_safe());
  CHECK(rig->schema().name == "toy");
  CHECK(rig->schema().units == "m");
  REQUIRE(rig->schema().control_count() == 2);
  CHECK(rig->schema().controls[0].name == "jaw");
  CHECK(rig->schema().controls[0].minimum == 0);
  CHECK(rig->schema().controls[0].maximum == 1);
  CHECK(rig->schema().controls[0].rest == 0);
  CHECK(rig->schema().controls[1].name == "brow");
  CHECK(rig->rest().polygon_sizes == std::vector<std::uint32_t>{3, 3, 3});
  CHECK(rig->rest().polygon_corners == std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 4, 5, 6});
  check_close(rig->rest().points, placed(rest_points));
  check_close(points_at(*rig, {0.5f, 1}), placed({0,    -.25f,  0, 1, -.25f,  .25f, 1, 1.75f,  .5f, 0, .75f,
                                                  .75f, 2.125f, 0, 0, 3.125f, 0,    0, 2.125f, 1,   1}));
}

TEST_CASE("texture coordinates are kept, v turned upwards, and 0 where a primitive has none") {
  ToyGltf toy;
  const auto uvs = [](const std::string& more) { return "\"count\":4,\"type\":\"VEC2\"" + more + "},"; };
  toy.replace(R"({"bufferView":0,"byteOffset":216,"componentType":5126,"count":6,"type":"SCALAR"}],)",
              R"({"bufferView":0,"byteOffset":216,"componentType":5126,"count":6,"type":"SCALAR"},
{"bufferView":0,"byteOffset":0,"componentType":5126,)" +
                  uvs("") + R"({"bufferView":0,"byteOffset":0,"componentType":5126,"count":3,"type":"VEC2"}],)");
  toy.replace(R"({"attributes":{"POSITION":0},)", R"({"attributes":{"POSITION":0,"TEXCOORD_0":10},)");
  const auto partial = toy.open();
  // The first numbers of the buffer are 0 0 0 1 0 0 1 1.
  CHECK(partial->rest().uvs == std::vector<float>{0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0});
  CHECK(partial->notes()[0] == "some texture coordinates are missing, and 0: \"toy\"");
  toy.replace(R"({"attributes":{"POSITION":2},"indices":3,"targets")",
              R"({"attributes":{"POSITION":2,"TEXCOORD_0":11},"indices":3,"targets")");
  const auto rig = toy.open();
  CHECK(rig->rest().uvs == std::vector<float>{0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1});
  CHECK(rig->rest().uv_corners == rig->rest().polygon_corners);
  toy.replace(R"("byteOffset":0,"componentType":5126,)" + uvs(""),
              R"("byteOffset":188,"componentType":5121,)" + uvs(",\"normalized\":true"));
  const auto normalised = toy.open();
  CHECK(normalised->rest().uvs[0] == 2.0f / 255);
  CHECK(normalised->rest().uvs[1] == 1);
  toy.replace(",\"normalized\":true", "");
  CHECK((*toy.open()).rest().uvs[0] == 2);
}

TEST_CASE("animations of the weights become clips of 30 frames a second") {
  const auto rig = ToyGltf().open();
  REQUIRE(rig->clips().size() == 2);
  const Clip &line = rig->clips()[0], &step = rig->clips()[1];
  CHECK(line.name == "talk");
  CHECK(step.name == "talk (2)");
  CHECK(line.kind == ClipKind::shot);
  CHECK(line.split == Split::train);
  CHECK(line.fps == 30);
  REQUIRE(line.frames == 7);
  check_close(line.controls,
              {0, 0, 1 / 3.f, .5f / 3, 2 / 3.f, 1 / 3.f, 1, .5f, 2.5f / 3, 2.5f / 3, 2 / 3.f, 3.5f / 3, .5f, 1.5f});
  check_close(step.controls, {0, 0, 0, 0, 0, 0, 1, .5f, 1, .5f, 1, .5f, .5f, 1.5f});
  std::vector<float> points(rig->rest().points.size());
  rig->read(0, 6, 1, points);
  CHECK(points == points_at(*rig, {.5f, 1.5f}));
}

TEST_CASE("unusual ranges and defaults are read and noted") {
  const auto notes = [](const Source& rig) {
    std::string all;
    for (const std::string& note : rig.notes()) all += note + "\n";
    return all;
  };
  const auto rig = ToyGltf().open();
  CHECK(rig->schema().controls[1].maximum == 1.5f);
  CHECK(contains(notes(*rig), "control \"brow\" ranges over 0..1.5"));

  ToyGltf resting;
  resting.replace(R"("extras":{"targetNames":["jaw","brow"]})", R"("weights":[0.25,0])");
  resting.replace(R"("path":"weights")", R"("path":"rotation")");
  const auto other = resting.open();
  CHECK(other->schema().controls[0].name == "target0");
  CHECK(other->schema().controls[0].rest == 0.25f);
  CHECK(other->rest().points == points_at(*other, {0.25f, 0}));
  CHECK(contains(notes(*other), "1 default weights are not 0"));
  CHECK(contains(notes(*other), "what animations move besides weights is left out: \"talk\""));
  CHECK(other->clips().size() == 1);
}

TEST_CASE("a text file with its data inside is read as well") {
  ToyGltf toy;
  static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t i = 0; i < toy.buffer.size(); i += 3) {
    const auto byte = [&](std::size_t k) { return std::uint32_t(static_cast<unsigned char>(toy.buffer[i + k])); };
    const std::uint32_t three = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += digits[three >> shift & 63];
  }
  toy.replace(R"({"byteLength":240})",
              R"({"byteLength":240,"uri":"data:application/octet-stream;base64,)" + base64 + "\"}");
  const auto rig = toy.open_bytes(toy.json, "toy.gltf");
  check_close(rig->rest().points, placed(rest_points));
}

TEST_CASE("what cannot be a rig is refused by name") {
  const struct {
    const char *from, *to;
    Status status;
    const char* message;
  } wrongs[] = {
      {R"("mesh":1,)", R"("mesh":1,"skin":0,)", Status::bad_data, "has a skin, and vertices without joints"},
      {R"("scale":[2,2,2])", R"("scale":[2,2,2],"children":[0])", Status::bad_data, "nodes are their own parents"},
      {R"("indices":1,)", R"("indices":1,"mode":9,)", Status::bad_data, "the unknown mode 9"},
      {R"({"POSITION":6})", R"({"POSITION":5})", Status::bad_data, "has 3 moves of target 1 where 4 are needed"},
      {R"({"POSITION":6})", R"({"POSITION":99})", Status::bad_data, "no accessor 99 for its moves of target 1"},
      {R"({"POSITION":6})", R"({"POSITION":9})", Status::unsupported, "moves of target 1 are not three floats"},
      {R"("byteOffset":192)", R"("byteOffset":232)", Status::bad_data, "run past the end"},
      {R"("byteOffset":188,)", R"("byteOffset":110,)", Status::bad_data, "of its moves of target 1 is"},
      {R"("sparse":{"count":1)", R"("sparse":{"count":-1)", Status::bad_data, "moves of target 1"},
      {R"("byteOffset":48,"componentType":5123)", R"("byteOffset":8,"componentType":5123)", Status::bad_data,
       "of its triangles is"},
      {R"("interpolation":"STEP")", R"("interpolation":"CUBICSPLINE")", Status::bad_data,
       "animation \"talk (2)\": has 6 key weights where 18 are needed"},
      {R"("interpolation":"STEP")", R"("interpolation":"EASE")", Status::bad_data,
       "animation \"talk (2)\": its weights are interpolated by EASE"},
      {R"("input":8,"output":9)", R"("input":9,"output":9)", Status::bad_data, "has 6 key weights where 12 are needed"},
      {R"("asset")", R"("extensionsRequired":["EXT_unheard_of"],"asset")", Status::unsupported,
       "requires the glTF extension EXT_unheard_of"},
      {R"({"byteLength":240})", R"({"byteLength":240,"uri":"face.bin"})", Status::not_found, "face.bin"},
      {R"({"byteLength":240})", R"({"byteLength":241})", Status::bad_data, "is no whole glTF file"},
      {R"({"byteLength":240})", R"({"byteLength":0})", Status::bad_data, "is no whole glTF file: a buffer is empty"},
  };
  for (const auto& wrong : wrongs) {
    CAPTURE(std::string(wrong.to));
    ToyGltf toy;
    toy.replace(wrong.from, wrong.to);
    const std::string what = failure(wrong.status, [&] { toy.open(); });
    CHECK_MESSAGE(contains(what, wrong.message), what);
    CHECK_MESSAGE(contains(what, "toy.glb: "), what);
  }
  ToyGltf still;
  still.replace(R"(,"targets":[{"POSITION":4},{"POSITION":6}])", "");
  still.replace(R"(,"targets":[{"POSITION":5},{"POSITION":7}])", "");
  CHECK(contains(failure(Status::bad_data, [&] { still.open(); }), "shows no mesh with morph targets"));
}

TEST_CASE("numbers that are not finite, and times that decrease, are refused by name") {
  const struct {
    std::size_t offset;
    float value;
    Status status;
    const char* message;
  } wrongs[] = {
      {12, NAN, Status::not_finite, "vertex 1 is not finite"},
      {152, INFINITY, Status::not_finite, "target 0: vertex 4 is not finite"},
      {208, -1, Status::bad_data, "the time of key 1 is -1"},
      {212, 1e30f, Status::limit, "animation \"talk\": 1e+30 s"},
      {220, NAN, Status::not_finite, "animation \"talk\": key 0: the weight of \"brow\""},
  };
  for (const auto& wrong : wrongs) {
    CAPTURE(wrong.offset);
    ToyGltf toy;
    toy.set(wrong.offset, wrong.value);
    const std::string what = failure(wrong.status, [&] { toy.open(); });
    CHECK_MESSAGE(contains(what, wrong.message), what);
  }
}

TEST_CASE("few keys are not resampled to very many frames") {
  const std::vector<float> rest(64);
  KeyTrack track{{0, 10000}, {0, 1}, {3}};  // 19.2 million values at 30 frames a second
  std::vector<std::size_t> contested;
  const auto frames = [&] { return resample(std::span(&track, 1), rest, {}, contested).frames; };
  CHECK(contains(failure(Status::limit, frames), "10000 s of 64 values are too long"));
  for (std::size_t key = 1; track.times.size() < 75016; ++key) {
    track.times.insert(track.times.end() - 1, 0.1f * static_cast<float>(key));
    track.values.insert(track.values.end() - 1, 0);
  }
  CHECK(frames() == 300001);
}

TEST_CASE("JSON that is nested too deep is refused before it is parsed") {
  for (const bool objects : {false, true}) {
    std::string deep;
    for (int i = 0; i < 20000; ++i) deep += objects ? "{\"a\":" : "[";
    deep += "0";
    for (int i = 0; i < 20000; ++i) deep += objects ? "}" : "]";
    ToyGltf toy;
    toy.replace(R"("extras":{)", R"("extras":{"x":)" + deep + ",");
    for (const bool binary : {false, true}) {
      const std::string what =
          failure(Status::bad_data, [&] { binary ? toy.open() : toy.open_bytes(toy.json, "toy.gltf"); });
      CHECK_MESSAGE(contains(what, "more than 64 objects and arrays deep"), what);
    }
  }
}

TEST_CASE("every prefix of a file is refused") {
  const ToyGltf toy;
  const std::string whole = toy.bytes();
  for (std::size_t size = 0; size < whole.size(); size += 7)
    CHECK(contains(failure(Status::bad_data, [&] { toy.open_bytes(whole.substr(0, size)); }), "toy.glb: "));
}

TEST_CASE("the linear recipe reproduces such a rig to the quantisation error") {
  const ToyGltf toy;
  const auto rig = toy.open();
  BakeOptions options;
  options.recipe = "linear";
  options.poses = 200;
  options.work = toy.folder / "work";
  const Evaluator face(read_archive(bake_face(*rig, options, silent_progress()).archive).model);
  Workspace workspace(face);
  Random random(5);
  double squares = 0;
  const std::size_t poses = 100, size = rig->rest().points.size();
  std::vector<float> points(size);
  for (std::size_t p = 0; p < poses; ++p) {
    const std::vector<float> weights = {static_cast<float>(random.uniform()),
                                        static_cast<float>(1.5 * random.uniform())};
    face.evaluate(weights.data(), points.data(), workspace);
    const std::vector<float> truth = points_at(*rig, weights);
    for (std::size_t i = 0; i < size; ++i) squares += std::pow(double(points[i]) - truth[i], 2);
  }
  const double mse = squares / double(poses * size) / std::pow(rig->rest().diagonal(), 2);
  MESSAGE("mse over the diagonal: " << mse);
  CHECK(mse <= 1e-10);
}

}  // namespace test_gltf_rig
