// A character as avatar services export it, written as a glTF file: five meshes that share one set of morph targets by
// name, a skin, materials with embedded pictures, and animations of several meshes at once. What it poses to is
// computed here, from the same numbers and the rules of glTF, without the reader that is tested.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace fb::test {

using Matrix = std::array<double, 16>;  // 4 x 4, column after column, as in glTF

inline Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return c;
}

// Appends values to a buffer, and views and accessors of them to the JSON of a glTF file.
class GltfBuffer {
 public:
  explicit GltfBuffer(nlohmann::json& json) : json_(json) {}

  int view(const void* bytes, std::size_t count) {
    while (data.size() % 4 != 0) data += '\0';
    json_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", count}});
    data.append(static_cast<const char*>(bytes), count);
    json_["buffers"] = {{{"byteLength", data.size()}}};
    return static_cast<int>(json_["bufferViews"].size()) - 1;
  }

  // `type`: "VEC3"; `width`: numbers of an element. Of floats with their bounds.
  template <class T>
  int accessor(const std::vector<T>& values, const char* type, std::size_t width) {
    const int component = std::is_same_v<T, float>           ? 5126
                          : std::is_same_v<T, std::uint32_t> ? 5125
                          : std::is_same_v<T, std::uint16_t> ? 5123
                          : std::is_same_v<T, std::int16_t>  ? 5122
                          : std::is_same_v<T, std::uint8_t>  ? 5121
                                                             : 5120;
    json_["accessors"].push_back({{"bufferView", view(values.data(), values.size() * sizeof(T))},
                                  {"componentType", component},
                                  {"count", values.size() / width},
                                  {"type", type}});
    if constexpr (std::is_same_v<T, float>) {
      std::vector<float> least(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(width)), most = least;
      for (std::size_t i = 0; i < values.size(); ++i) {
        least[i % width] = std::min(least[i % width], values[i]);
        most[i % width] = std::max(most[i % width], values[i]);
      }
      json_["accessors"].back()["min"] = least;
      json_["accessors"].back()["max"] = most;
    }
    return static_cast<int>(json_["accessors"].size()) - 1;
  }

  std::string data;

 private:
  nlohmann::json& json_;
};

// The bytes of a .glb.
inline std::string glb_file(const nlohmann::json& json, const std::string& buffer) {
  const auto word = [](std::size_t n) {
    const auto u = static_cast<std::uint32_t>(n);
    return std::string(reinterpret_cast<const char*>(&u), 4);
  };
  std::string text = json.dump(), padded = buffer;
  text.resize((text.size() + 3) / 4 * 4, ' ');
  padded.resize((padded.size() + 3) / 4 * 4, '\0');
  return "glTF" + word(2) + word(28 + text.size() + padded.size()) + word(text.size()) + "JSON" + text +
         word(padded.size()) + std::string("BIN\0", 4) + padded;
}

// Two pictures of 2 x 2 and 1 x 1 pixels.
inline const std::vector<std::uint8_t> skin_png = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52,
    0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02, 0x00, 0x00, 0x00, 0xfd, 0xd4, 0x9a,
    0x73, 0x00, 0x00, 0x00, 0x17, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x78, 0xb0, 0x61, 0xc1,
    0x8d, 0x05, 0x13, 0x18, 0x4e, 0x4c, 0x68, 0x78, 0xb1, 0x63, 0x05, 0x00, 0x3b, 0x6e, 0x08, 0x59,
    0x0d, 0xf0, 0x0e, 0x95, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
inline const std::vector<std::uint8_t> normal_png = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
    0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00, 0x00, 0x90, 0x77, 0x53, 0xde, 0x00, 0x00, 0x00,
    0x0c, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x68, 0x68, 0xf8, 0x0f, 0x00, 0x03, 0x83, 0x02, 0x00, 0x00,
    0xa5, 0xfb, 0x89, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

class GltfAvatar {
 public:
  // A mesh as a node shows it, in the mesh's own coordinates.
  struct Part {
    std::string name;
    std::vector<float> points;
    std::vector<std::uint32_t> triangles;
    std::vector<float> uvs;                             // as in glTF: v counts downwards
    std::map<std::string, std::vector<float>> targets;  // offsets of all vertices
    std::vector<std::uint8_t> joints;                   // 4 a vertex; empty: no skin
    std::vector<float> weights;
    std::vector<std::size_t> nodes;  // that place it, from the root on
  };

  // Indices of nodes, which tests change.
  enum Node { armature, neck, head, head_mesh, left_eye, right_eye, teeth_mesh, tongue_mesh, hidden };

  GltfAvatar() : buffer_(json) {
    json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {armature}}}}}};
    add_nodes();
    add_materials();
    add_head();
    add_eyes();
    add_teeth();
    add_tongue();
    add_skin();
    add_animations();
  }
  GltfAvatar(const GltfAvatar&) = delete;

  const std::string& buffer() const { return buffer_.data; }
  GltfBuffer& more() { return buffer_; }
  std::string glb() const { return glb_file(json, buffer_.data); }

  // All points in a pose: 3 a vertex, part after part.
  std::vector<double> points(const std::map<std::string, double>& weights) const {
    std::vector<double> all;
    for (const Part& part : parts)
      for (std::size_t v = 0; v < part.points.size() / 3; ++v) {
        std::array<double, 3> at{};
        for (std::size_t k = 0; k < 3; ++k) {
          at[k] = double(part.points[3 * v + k]);
          for (const auto& [name, offsets] : part.targets)
            if (const auto found = weights.find(name); found != weights.end())
              at[k] += found->second * double(offsets[3 * v + k]);
        }
        const Matrix map = map_of(part, v);
        for (std::size_t k = 0; k < 3; ++k)
          all.push_back(map[k] * at[0] + map[4 + k] * at[1] + map[8 + k] * at[2] + map[12 + k]);
      }
    return all;
  }

  nlohmann::json json;
  std::vector<Part> parts;

 private:
  // A turn around z by a number of degrees, a scale and a translation.
  static Matrix placed(double x, double y, double z, double degrees = 0, double scale = 1) {
    const double a = degrees * std::acos(-1.0) / 180, c = scale * std::cos(a), s = scale * std::sin(a);
    return {c, s, 0, 0, -s, c, 0, 0, 0, 0, scale, 0, x, y, z, 1};
  }

  Matrix world(const std::vector<std::size_t>& nodes) const {
    Matrix map = placed(0, 0, 0);
    for (const std::size_t node : nodes) map = product(map, locals_[node]);
    return map;
  }

  // The skin's joints are neck and head; their inverse bind matrices are in inverses_.
  Matrix map_of(const Part& part, std::size_t vertex) const {
    if (part.joints.empty()) return world(part.nodes);
    const Matrix of_joints[2] = {product(world({armature, neck}), inverses_[0]),
                                 product(world({armature, neck, head}), inverses_[1])};
    Matrix map{};
    double sum = 0;
    for (std::size_t k = 4 * vertex; k < 4 * vertex + 4; ++k) {
      sum += double(part.weights[k]);
      for (std::size_t i = 0; i < 16; ++i) map[i] += double(part.weights[k]) * of_joints[part.joints[k]][i];
    }
    for (double& x : map) x /= sum;
    return map;
  }

  void add_nodes() {
    locals_ = {placed(0, 0.5, 0, 0, 2), placed(0, 1, 0, 30),           placed(0, 0.5, 0.25, -20),
               placed(5, 5, 5, 45, 3),  placed(0.5, 0.5, 1),           placed(-0.5, 0.5, 1, 90),
               placed(7, 7, 7),         placed(0, -0.5, 0.5, 10, 0.5), placed(0, 0, 0)};
    const char* names[] = {"Armature", "Neck",         "Head", "Wolf3D_Head", "EyeLeft",
                           "EyeRight", "Wolf3D_Teeth", "",     "Hidden"};
    for (std::size_t n = 0; n < locals_.size(); ++n)
      json["nodes"].push_back({{"name", names[n]}, {"matrix", locals_[n]}});
    // Nodes that are animated have their transforms in parts.
    const auto in_parts = [&](Node node, std::vector<double> translation, double degrees) {
      const double half = degrees * std::acos(-1.0) / 360;
      json["nodes"][node].erase("matrix");
      json["nodes"][node]["translation"] = translation;
      json["nodes"][node]["rotation"] = {0, 0, std::sin(half), std::cos(half)};
      json["nodes"][node]["scale"] = {1, 1, 1};
    };
    in_parts(neck, {0, 1, 0}, 30);
    in_parts(head, {0, 0.5, 0.25}, -20);
    json["nodes"][armature]["children"] = {neck, head_mesh, teeth_mesh};
    json["nodes"][neck]["children"] = {head};
    json["nodes"][head]["children"] = {left_eye, right_eye, tongue_mesh};
    const std::pair<Node, int> meshes[] = {{head_mesh, 0},  {left_eye, 1},    {right_eye, 1},
                                           {teeth_mesh, 2}, {tongue_mesh, 3}, {hidden, 3}};
    for (const auto& [node, mesh] : meshes) json["nodes"][node]["mesh"] = mesh;
    json["nodes"][head_mesh]["skin"] = json["nodes"][teeth_mesh]["skin"] = 0;
  }

  void add_materials() {
    const int skin = buffer_.view(skin_png.data(), skin_png.size()),
              normal = buffer_.view(normal_png.data(), normal_png.size());
    json["images"] = {{{"name", "unused"}, {"bufferView", skin}, {"mimeType", "image/png"}},
                      {{"name", "skin"}, {"bufferView", skin}, {"mimeType", "image/png"}},
                      {{"name", "normals"}, {"bufferView", normal}, {"mimeType", "image/png"}}};
    json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
    json["textures"] = {{{"source", 1}, {"sampler", 0}}, {{"source", 2}}};
    json["materials"] = {
        {{"name", "unused"}},
        {{"name", "Wolf3D_Skin"},
         {"doubleSided", true},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {1, 0.5, 0.25, 1}},
           {"metallicFactor", 0},
           {"roughnessFactor", 0.75},
           {"baseColorTexture", {{"index", 0}}}}},
         {"normalTexture", {{"index", 1}, {"scale", 0.5}}},
         {"occlusionTexture", {{"index", 0}, {"strength", 0.25}}}},
        {{"name", "Wolf3D_Brows"}, {"alphaMode", "MASK"}, {"alphaCutoff", 0.25}, {"emissiveFactor", {0, 0.5, 1}}},
        {{"name", "Wolf3D_Teeth"}, {"pbrMetallicRoughness", {{"metallicFactor", 0}}}}};
  }

  // A primitive of a part's vertices from `first` on, whose triangles count from there.
  nlohmann::json primitive(const Part& part, std::size_t first, std::size_t vertices,
                           const std::vector<std::uint16_t>& corners, const std::vector<std::string>& names) {
    const auto slice = [&](const auto& values, std::size_t width) {
      return std::vector(values.begin() + static_cast<std::ptrdiff_t>(width * first),
                         values.begin() + static_cast<std::ptrdiff_t>(width * (first + vertices)));
    };
    nlohmann::json made;
    made["attributes"]["POSITION"] = buffer_.accessor(slice(part.points, 3), "VEC3", 3);
    if (!part.uvs.empty()) made["attributes"]["TEXCOORD_0"] = buffer_.accessor(slice(part.uvs, 2), "VEC2", 2);
    if (!part.joints.empty()) {
      made["attributes"]["JOINTS_0"] = buffer_.accessor(slice(part.joints, 4), "VEC4", 4);
      made["attributes"]["WEIGHTS_0"] = buffer_.accessor(slice(part.weights, 4), "VEC4", 4);
    }
    made["indices"] = buffer_.accessor(corners, "SCALAR", 1);
    for (const std::string& name : names)
      made["targets"].push_back({{"POSITION", buffer_.accessor(slice(part.targets.at(name), 3), "VEC3", 3)}});
    return made;
  }

  // A sheet of columns x rows vertices in the xy plane from a corner on, bulging along z.
  static void add_sheet(Part& part, std::uint16_t columns, std::uint16_t rows, float x, float y, float z,
                        std::vector<std::uint16_t>& corners) {
    const std::size_t first = part.points.size() / 3;
    for (std::uint16_t r = 0; r < rows; ++r)
      for (std::uint16_t c = 0; c < columns; ++c) {
        const float u = float(c) / float(columns - 1), v = float(r) / float(rows - 1);
        part.points.insert(part.points.end(), {x + u, y + v, z + 0.25f * (u - u * u) + 0.125f * v});
        part.uvs.insert(part.uvs.end(), {u, 0.5f * v});
      }
    for (std::uint16_t r = 0; r + 1 < rows; ++r)
      for (std::uint16_t c = 0; c + 1 < columns; ++c) {
        const auto at = static_cast<std::uint16_t>(r * columns + c), next = static_cast<std::uint16_t>(at + columns);
        for (const int corner : {at + 0, at + 1, next + 1, at + 0, next + 1, next + 0})
          corners.push_back(static_cast<std::uint16_t>(corner));
      }
    for (std::size_t i = corners.size() - std::size_t(6) * (columns - 1u) * (rows - 1u); i < corners.size(); ++i)
      part.triangles.push_back(static_cast<std::uint32_t>(first + corners[i]));
  }

  // A target that moves each vertex by an amount of its own.
  static void add_target(Part& part, const std::string& name, float x, float y, float z) {
    std::vector<float>& offsets = part.targets[name];
    for (std::size_t v = 0; v < part.points.size() / 3; ++v) {
      const float share = float(v % 5) / 4;
      offsets.insert(offsets.end(), {x * share, y * share, z * share * share});
    }
  }

  static void add_joints(Part& part) {
    for (std::size_t v = 0; v < part.points.size() / 3; ++v) {
      part.joints.insert(part.joints.end(), {0, 1, 0, 0});
      part.weights.insert(part.weights.end(), {float(v % 4) / 4, 1 - float(v % 4) / 4, 0, 0});
    }
  }

  void add_head() {
    Part& part = parts.emplace_back();
    part.name = "Wolf3D_Head";
    std::vector<std::uint16_t> face, brows;
    add_sheet(part, 6, 5, 0, 0, 0, face);
    const std::size_t of_face = part.points.size() / 3;
    add_sheet(part, 3, 2, 0, 0.75f, 0.5f, brows);
    const std::vector<std::string> names = {"jawOpen", "browInnerUp", "mouthSmileLeft"};
    add_target(part, names[0], 0, -0.5f, 0.25f);
    add_target(part, names[1], 0, 0.25f, 0);
    add_target(part, names[2], 0.25f, 0.125f, -0.5f);
    add_joints(part);
    nlohmann::json of_skin = primitive(part, 0, of_face, face, names),
                   of_brows = primitive(part, of_face, 6, brows, names);
    of_skin["material"] = 1;
    of_brows["material"] = 2;
    json["meshes"].push_back(
        {{"name", "head"}, {"primitives", {of_skin, of_brows}}, {"extras", {{"targetNames", names}}}});
  }

  // One mesh that two nodes show, without texture coordinates and without material.
  void add_eyes() {
    Part eye;
    std::vector<std::uint16_t> corners;
    add_sheet(eye, 3, 3, -0.5f, -0.5f, 0, corners);
    eye.uvs.clear();
    nlohmann::json primitive_of_eye = primitive(eye, 0, 9, corners, {});
    json["meshes"].push_back({{"name", "eye"}, {"primitives", {primitive_of_eye}}});
    eye.name = "EyeLeft";
    eye.nodes = {armature, neck, head, left_eye};
    parts.push_back(eye);
    eye.name = "EyeRight";
    eye.nodes.back() = right_eye;
    parts.push_back(eye);
  }

  void add_teeth() {
    Part& part = parts.emplace_back();
    part.name = "Wolf3D_Teeth";
    std::vector<std::uint16_t> corners;
    add_sheet(part, 4, 2, 0, -0.5f, 0.25f, corners);
    add_target(part, "jawOpen", 0, -0.25f, 0);
    add_joints(part);
    nlohmann::json teeth = primitive(part, 0, 8, corners, {"jawOpen"});
    teeth["material"] = 3;
    json["meshes"].push_back({{"name", "teeth"}, {"primitives", {teeth}}, {"extras", {{"targetNames", {"jawOpen"}}}}});
  }

  void add_tongue() {
    Part& part = parts.emplace_back();
    part.name = "tongue";
    part.nodes = {armature, neck, head, tongue_mesh};
    std::vector<std::uint16_t> corners;
    add_sheet(part, 3, 3, 0, 0, 0, corners);
    add_target(part, "tongueOut", 0, 0, 1);
    add_target(part, "jawOpen", 0, -0.5f, 0);
    const std::vector<std::string> names = {"tongueOut", "jawOpen"};
    nlohmann::json tongue = primitive(part, 0, 9, corners, names);
    tongue["material"] = 3;
    json["meshes"].push_back({{"name", "tongue"}, {"primitives", {tongue}}, {"extras", {{"targetNames", names}}}});
  }

  void add_skin() {
    inverses_ = {placed(0.25, -0.5, 0, -15), placed(0, -1, 0.5, 40)};
    std::vector<float> floats;
    for (Matrix& inverse : inverses_)
      for (double& x : inverse) {
        floats.push_back(static_cast<float>(x));
        x = double(floats.back());  // as the file has it
      }
    json["skins"] = {{{"joints", {neck, head}}, {"inverseBindMatrices", buffer_.accessor(floats, "MAT4", 16)}}};
  }

  // "talk" moves head, teeth and tongue with keys of their own, and the neck.
  void add_animations() {
    const auto sampler = [&](const std::vector<float>& times, const std::vector<float>& values, const char* type,
                             std::size_t width, const char* interpolation) {
      return nlohmann::json{{"input", buffer_.accessor(times, "SCALAR", 1)},
                            {"output", buffer_.accessor(values, type, width)},
                            {"interpolation", interpolation}};
    };
    const auto channel = [](int index, int node, const char* path) {
      return nlohmann::json{{"sampler", index}, {"target", {{"node", node}, {"path", path}}}};
    };
    json["animations"] = {{{"name", "talk"},
                           {"samplers",
                            {sampler({0, 0.2f}, {0, 0, 0, 1, 0.5f, 0.25f}, "SCALAR", 1, "LINEAR"),
                             sampler({0, 0.2f}, {0, 1}, "SCALAR", 1, "LINEAR"),
                             sampler({0.1f, 0.3f}, {0, 0.5f, 1, 1}, "SCALAR", 1, "STEP"),
                             sampler({0, 0.2f}, {0, 0, 0, 1, 0, 0, 1, 0}, "VEC4", 4, "LINEAR")}},
                           {"channels",
                            {channel(0, head_mesh, "weights"), channel(1, teeth_mesh, "weights"),
                             channel(2, tongue_mesh, "weights"), channel(3, neck, "rotation")}}},
                          {{"name", "nod"},
                           {"samplers", {sampler({0, 1}, {0, 0, 0, 1, 0, 0, 1, 0}, "VEC4", 4, "LINEAR")}},
                           {"channels", {channel(0, head, "rotation")}}}};
  }

  GltfBuffer buffer_;
  std::vector<Matrix> locals_;    // of the nodes
  std::vector<Matrix> inverses_;  // of the joints
};

}  // namespace fb::test
