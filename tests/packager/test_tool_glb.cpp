// pose writes glTF that a reader who knows nothing of us turns back into the evaluator's positions.
#include <doctest/doctest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tool_files.h"
#include "tool_run.h"

namespace {

tinygltf::Model load(const std::string& path) {
  tinygltf::Model model;
  tinygltf::TinyGLTF loader;
  std::string error, warning;
  const bool loaded = loader.LoadBinaryFromFile(&model, &error, &warning, path);
  CAPTURE(error);
  CAPTURE(warning);
  REQUIRE(loaded);
  CHECK(error.empty());
  CHECK(warning.empty());
  return model;
}

template <class T>
std::vector<T> view_values(const tinygltf::Model& model, int view, std::size_t offset, std::size_t count) {
  const auto& v = model.bufferViews.at(view);
  const auto& data = model.buffers.at(v.buffer).data;
  REQUIRE(v.byteOffset + offset + count * sizeof(T) <= data.size());
  REQUIRE(offset + count * sizeof(T) <= v.byteLength);
  std::vector<T> values(count);
  std::memcpy(values.data(), data.data() + v.byteOffset + offset, count * sizeof(T));
  return values;
}

// Floats of an accessor, sparse or not, that lie within the bounds it states.
std::vector<float> floats(const tinygltf::Model& model, int index) {
  const auto& a = model.accessors.at(index);
  REQUIRE(a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT);
  const std::size_t width = a.type == TINYGLTF_TYPE_VEC3 ? 3 : 1;
  std::vector<float> values(a.count * width);
  if (a.bufferView >= 0) values = view_values<float>(model, a.bufferView, a.byteOffset, values.size());
  if (a.sparse.isSparse) {
    const auto where = view_values<std::uint32_t>(model, a.sparse.indices.bufferView, 0, a.sparse.count);
    const auto what = view_values<float>(model, a.sparse.values.bufferView, 0, a.sparse.count * width);
    CHECK(std::is_sorted(where.begin(), where.end()));
    for (std::size_t i = 0; i < where.size(); ++i) {
      REQUIRE(where[i] < a.count);
      std::copy_n(&what[i * width], width, &values[where[i] * width]);
    }
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    CHECK(values[i] >= a.minValues.at(i % width));
    CHECK(values[i] <= a.maxValues.at(i % width));
  }
  return values;
}

void check_unit_length(const std::vector<float>& normals) {
  for (std::size_t v = 0; v < normals.size(); v += 3)
    CHECK(std::hypot(normals[v], normals[v + 1], normals[v + 2]) == doctest::Approx(1).epsilon(1e-4));
}

float largest_difference(const float* a, const float* b, std::size_t count) {
  float largest = 0;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
  return largest;
}

// The animation played as the glTF specification says: morph targets weighted and added to the base.
void check_animation(std::size_t frames, std::size_t largest_target_count) {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", clip = folder / "clip.npy", out = folder / "clip.glb";
  const fb::FaceModel face = write_tiny_archive(archive);
  const auto expected = evaluate_clip(face, write_clip(clip, face.schema, frames));
  REQUIRE(run_tool({"pose", archive, "--clip", clip, "--fps", "24", "--out", out}).exit_code == 0);
  const tinygltf::Model model = load(out);
  const auto& primitive = model.meshes.at(0).primitives.at(0);
  const std::size_t targets = primitive.targets.size(), size = face.rest.points.size();
  REQUIRE(targets > 0);
  CHECK(targets <= largest_target_count);
  CHECK(model.meshes[0].weights.size() == targets);
  const auto& animation = model.animations.at(0);
  CHECK(animation.channels.at(0).target_path == "weights");
  const auto times = floats(model, animation.samplers.at(0).input);
  const auto weights = floats(model, animation.samplers.at(0).output);
  REQUIRE(times.size() == frames);
  REQUIRE(weights.size() == frames * targets);
  CHECK(times[frames - 1] == doctest::Approx((frames - 1) / 24.0));
  const auto base = floats(model, primitive.attributes.at("POSITION")),
             normals = floats(model, primitive.attributes.at("NORMAL"));
  check_unit_length(normals);
  std::vector<std::vector<float>> moves, turns;
  for (const auto& target : primitive.targets) {
    moves.push_back(floats(model, target.at("POSITION")));
    turns.push_back(floats(model, target.at("NORMAL")));
  }
  for (std::size_t f = 0; f < frames; ++f) {
    std::vector<float> points = base, bent = normals;
    for (std::size_t t = 0; t < targets; ++t)
      for (std::size_t i = 0; i < size; ++i) {
        points[i] += weights[f * targets + t] * moves[t][i];
        bent[i] += weights[f * targets + t] * turns[t][i];
      }
    CHECK(largest_difference(points.data(), &expected[f * size], size) < 1e-6 * face.rest.diagonal());
    if (targets == frames) check_unit_length(bent);
  }
}

}  // namespace

TEST_CASE("a pose becomes one mesh with every vertex in order, normals and triangles") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", out = folder / "pose.glb";
  const fb::FaceModel face = write_tiny_archive(archive);
  REQUIRE(run_tool({"pose", archive, "--set", "jaw_open=1", "--out", out}).exit_code == 0);
  auto controls = face.schema.rest_pose();
  controls[0] = 1;
  const tinygltf::Model model = load(out);
  CHECK(model.asset.version == "2.0");
  CHECK(model.animations.empty());
  CHECK(model.nodes.at(0).scale == std::vector<double>(3, 0.01));  // centimetres
  const auto& primitive = model.meshes.at(0).primitives.at(0);
  CHECK(floats(model, primitive.attributes.at("POSITION")) == evaluate_clip(face, controls));
  check_unit_length(floats(model, primitive.attributes.at("NORMAL")));
  const auto& indices = model.accessors.at(primitive.indices);
  CHECK(view_values<std::uint32_t>(model, indices.bufferView, 0, indices.count) == face.rest.triangles());
}

TEST_CASE("a short clip becomes its frames as morph targets") {
  check_animation(4, 4);
}

TEST_CASE("a long clip becomes the basis as morph targets") {
  check_animation(40, 5);
}
