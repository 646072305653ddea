// Loads a baked face, sets controls by name and writes the posed mesh as a .glb that any viewer opens.
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <facebaker/facebaker.hpp>

namespace {

// The model's polygons as triangle fans from their first corners.
std::vector<std::uint32_t> triangles(const facebaker::Model& model) {
  std::vector<std::uint32_t> indices;
  const std::uint32_t* corner = fb_polygon_corners(model.get());
  for (std::uint32_t p = 0; p < fb_polygon_count(model.get()); ++p) {
    const std::uint32_t size = fb_polygon_sizes(model.get())[p];
    for (std::uint32_t k = 1; k + 1 < size; ++k) indices.insert(indices.end(), {corner[0], corner[k], corner[k + 1]});
    corner += size;
  }
  return indices;
}

// Area-weighted vertex normals.
std::vector<float> normals(const std::vector<float>& points, const std::vector<std::uint32_t>& indices) {
  std::vector<float> sums(points.size());
  for (std::size_t t = 0; t < indices.size(); t += 3) {
    const float *a = &points[3 * indices[t]], *b = &points[3 * indices[t + 1]], *c = &points[3 * indices[t + 2]];
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const float area = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
      for (int k = 0; k < 3; ++k) sums[3 * indices[t + k] + axis] += area;
    }
  }
  for (std::size_t i = 0; i < sums.size(); i += 3) {
    const float length = std::hypot(sums[i], sums[i + 1], sums[i + 2]);
    for (int axis = 0; axis < 3; ++axis) sums[i + axis] = length > 0 ? sums[i + axis] / length : axis == 2;
  }
  return sums;
}

// Appends an array to the file's buffer with a view and an accessor; returns the accessor's index.
template <class T>
int add_array(tinygltf::Model& file, const std::vector<T>& values, int width, int component, int target) {
  auto& data = file.buffers[0].data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = values.size() * sizeof(T);
  view.target = target;
  data.resize(data.size() + view.byteLength);
  std::memcpy(data.data() + view.byteOffset, values.data(), view.byteLength);
  file.bufferViews.push_back(view);

  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(file.bufferViews.size()) - 1;
  accessor.componentType = component;
  accessor.type = width == 3 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_SCALAR;
  accessor.count = values.size() / width;
  for (int k = 0; k < width; ++k) {  // glTF requires the bounds of positions
    T low = values[k], high = values[k];
    for (std::size_t i = k; i < values.size(); i += width) {
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
    }
    accessor.minValues.push_back(low);
    accessor.maxValues.push_back(high);
  }
  file.accessors.push_back(accessor);
  return static_cast<int>(file.accessors.size()) - 1;
}

bool write_glb(const char* path, const facebaker::Model& model, const std::vector<float>& points) {
  const auto indices = triangles(model);
  tinygltf::Model file;
  file.asset.version = "2.0";
  file.asset.generator = "FaceBaker pose_face";
  file.buffers.resize(1);
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] =
      add_array(file, points, 3, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TARGET_ARRAY_BUFFER);
  primitive.attributes["NORMAL"] =
      add_array(file, normals(points, indices), 3, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TARGET_ARRAY_BUFFER);
  primitive.indices =
      add_array(file, indices, 1, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  file.meshes.resize(1);
  file.meshes[0].primitives.push_back(primitive);
  tinygltf::Node node;
  node.mesh = 0;
  node.name = model.name();
  if (std::strcmp(fb_units(model.get()), "cm") == 0) node.scale = {0.01, 0.01, 0.01};  // glTF units are metres
  if (std::strcmp(fb_up_axis(model.get()), "z") == 0) node.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
  file.nodes.push_back(node);
  file.scenes.resize(1);
  file.scenes[0].nodes = {0};
  file.defaultScene = 0;
  return tinygltf::TinyGLTF().WriteGltfSceneToFile(&file, path, true, true, false, true);
}

int pose_face(int argc, char** argv) {
  const facebaker::Model model(argv[1]);
  if (fb_polygon_count(model.get()) == 0) {
    std::fprintf(stderr, "%s: has no polygons\n", argv[1]);
    return 1;
  }
  std::vector<float> controls = model.rest_controls(), points(3 * std::size_t{model.vertex_count()});
  for (int i = 3; i < argc; ++i) {
    const char* equals = std::strchr(argv[i], '=');
    if (!equals) {
      std::fprintf(stderr, "%s: give NAME=VALUE\n", argv[i]);
      return 2;
    }
    controls[model.find({argv[i], static_cast<std::size_t>(equals - argv[i])})] = std::strtof(equals + 1, nullptr);
  }
  facebaker::Scratch scratch(model);
  scratch.evaluate(controls.data(), points.data());
  if (scratch.clamped_count() > 0) std::fprintf(stderr, "some values were clamped to their ranges\n");
  if (!write_glb(argv[2], model, points)) {
    std::fprintf(stderr, "%s: cannot be written\n", argv[2]);
    return 1;
  }
  std::printf("%s: %u vertices posed\n", argv[2], model.vertex_count());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: pose_face FACE.fbk OUT.glb [CONTROL=VALUE ...]\n");
    return 2;
  }
  try {
    return pose_face(argc, argv);
  } catch (const facebaker::Error& error) {
    std::fprintf(stderr, "%s: %s\n", fb_status_name(error.status()), error.what());
    return 1;
  }
}
