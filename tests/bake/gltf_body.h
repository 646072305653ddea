// A body and a head on one skeleton, written as a glTF file: two skins with orders of joints and units of their own,
// eyes that hang on a joint, morph targets of the head, and an animation that moves joints by metres while the face
// moves. The file shows it in another pose than that in which it was bound.
#pragma once

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gltf_avatar.h"

namespace fb::test {

class GltfBody {
 public:
  enum Node { armature, hips, spine, neck, head, eye_joint, body_mesh, head_mesh, eye_mesh, nodes };
  static constexpr std::size_t frames = 24;
  static inline const std::vector<std::string> names = {"Armature", "Hips", "Spine",      "Neck", "Head",
                                                        "EyeJoint", "Body", "Head shape", "Eye"};
  static inline const std::vector<std::string> targets = {"jawOpen", "smile"};

  GltfBody() : buffer_(json) {
    json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {armature, head_mesh, body_mesh}}}}}};
    const int parents[nodes] = {-1, armature, hips, spine, neck, head, -1, -1, eye_joint};
    for (std::size_t n = 0; n < nodes; ++n) {
      json["nodes"].push_back({{"name", names[n]}});
      if (parents[n] >= 0) json["nodes"][std::size_t(parents[n])]["children"].push_back(n);
      if (n <= eye_joint) set(json["nodes"][n], local(n, 1));  // the file shows it as in frame 1
    }
    json["nodes"][eye_mesh]["translation"] = {0.0, 0.25, 0.5};
    // How it was bound: in the first frame; from the joints to the scene.
    for (std::size_t n = 0; n <= eye_joint; ++n)
      bound_.push_back(parents[n] < 0 ? matrix(local(n, 0))
                                      : product(bound_[std::size_t(parents[n])], matrix(local(n, 0))));
    add_body();
    add_head();
    add_eye();
    add_animation();
  }
  GltfBody(const GltfBody&) = delete;

  std::string glb() const { return glb_file(json, buffer_.data); }

  // What a joint does in a frame: moved, turned around an axis, by an angle. Hips go three metres away.
  struct Local {
    double move[3], axis[3], angle, scale;
  };
  static Local local(std::size_t node, std::size_t frame) {
    const double t = double(frame) / double(frames - 1), wave = std::sin(6 * t);
    switch (node) {
      case armature:
        return {{0, 0, 0}, {1, 0, 0}, -0.5, 0.5};
      case hips:
        return {{6 * t, 2 - wave, 5 * t}, {0, 1, 0}, 2.5 * t, 1};
      case spine:
        return {{0, 1, 0.25}, {0, 0, 1}, 0.5 * wave, 1};
      case neck:
        return {{0, 1.5, 0}, {1, 0, 0}, 0.75 * wave - 0.25, 1};
      case head:
        return {{0, 0.5, 0.125}, {0.6, 0.8, 0}, 1.25 * t, 1};
      default:
        return {{0.25, 0.25, 0.25}, {0, 1, 0}, wave, 1};
    }
  }
  static double weight(std::size_t target, std::size_t frame) {
    const double t = double(frame) / double(frames - 1);
    return target == 0 ? 0.5 - 0.5 * std::cos(12 * t) : t;
  }
  // Column after column.
  static Matrix matrix(const Local& local) {
    const double c = std::cos(local.angle), s = std::sin(local.angle);
    const auto [x, y, z] = local.axis;
    const double turn[9] = {c + x * x * (1 - c),     y * x * (1 - c) + z * s, z * x * (1 - c) - y * s,
                            x * y * (1 - c) - z * s, c + y * y * (1 - c),     z * y * (1 - c) + x * s,
                            x * z * (1 - c) + y * s, y * z * (1 - c) - x * s, c + z * z * (1 - c)};
    Matrix m{};
    for (std::size_t i = 0; i < 9; ++i) m[i / 3 * 4 + i % 3] = local.scale * turn[i];
    for (std::size_t i = 0; i < 3; ++i) m[12 + i] = local.move[i];
    m[15] = 1;
    return m;
  }

  nlohmann::json json;

 private:
  static std::vector<double> quaternion(const Local& local) {
    const double s = std::sin(local.angle / 2);
    return {s * local.axis[0], s * local.axis[1], s * local.axis[2], std::cos(local.angle / 2)};
  }
  static void set(nlohmann::json& node, const Local& local) {
    node["translation"] = local.move;
    node["rotation"] = quaternion(local);
    node["scale"] = {local.scale, local.scale, local.scale};
  }

  // Of a matrix that turns, scales alike and moves.
  static Matrix inverse(const Matrix& m) {
    double square = 0;
    for (std::size_t i = 0; i < 3; ++i) square += m[i] * m[i];
    Matrix back{};
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 3; ++column) back[4 * column + row] = m[4 * row + column] / square;
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t k = 0; k < 3; ++k) back[12 + row] -= back[4 * k + row] * m[12 + k];
    back[15] = 1;
    return back;
  }

  // A tube around y of rings of eight vertices, with tips that close it, in metres of the pose of binding.
  static void add_tube(std::vector<float>& points, std::vector<std::uint16_t>& corners, double x, double y, double z,
                       double radius, double height, std::size_t rings) {
    const std::size_t first = points.size() / 3;
    for (std::size_t r = 0; r < rings; ++r)
      for (std::size_t k = 0; k < 8; ++k) {
        const double a = double(k) * 0.785398163, wide = radius * (1 + 0.25 * std::sin(3.0 * double(r) + a));
        points.insert(points.end(), {float(x + wide * std::cos(a)), float(y + height * double(r) / double(rings - 1)),
                                     float(z + wide * std::sin(a))});
      }
    for (std::size_t r = 0; r + 1 < rings; ++r)
      for (std::size_t k = 0; k < 8; ++k) {
        const std::size_t a = first + 8 * r + k, b = first + 8 * r + (k + 1) % 8;
        for (const std::size_t corner : {a, a + 8, b + 8, a, b + 8, b}) corners.push_back(std::uint16_t(corner));
      }
  }

  // `map`: from the mesh to the pose of binding.
  int add_skin(const std::vector<int>& joints, const Matrix& map) {
    std::vector<float> floats;
    for (const int joint : joints)
      for (const double x : product(inverse(bound_[std::size_t(joint)]), map)) floats.push_back(float(x));
    json["skins"].push_back({{"joints", joints}, {"inverseBindMatrices", buffer_.accessor(floats, "MAT4", 16)}});
    return static_cast<int>(json["skins"].size()) - 1;
  }

  // From one joint of the skin to the next along y, two joints a vertex.
  static void add_weights(const std::vector<float>& points, double from, double to, std::size_t joints,
                          std::vector<std::uint8_t>& of_vertices, std::vector<float>& weights) {
    for (std::size_t v = 0; v < points.size() / 3; ++v) {
      const double along = std::clamp((double(points[3 * v + 1]) - from) / (to - from), 0.0, 0.9999);
      const double at = along * double(joints - 1), share = at - std::floor(at);
      const auto joint = std::uint8_t(std::floor(at));
      of_vertices.insert(of_vertices.end(), {joint, std::uint8_t(joint + 1), 0, 0});
      weights.insert(weights.end(), {float(1 - share), float(share), 0, 0});
    }
  }

  nlohmann::json skinned_mesh(Node node, int skin, const std::vector<float>& points,
                              const std::vector<std::uint16_t>& corners, const std::vector<std::uint8_t>& joints,
                              const std::vector<float>& weights) {
    json["nodes"][node]["mesh"] = json["meshes"].size();
    json["nodes"][node]["skin"] = skin;
    json["nodes"][node]["translation"] = {9, 9, 9};  // without effect
    nlohmann::json primitive;
    primitive["attributes"] = {{"POSITION", buffer_.accessor(points, "VEC3", 3)},
                               {"JOINTS_0", buffer_.accessor(joints, "VEC4", 4)},
                               {"WEIGHTS_0", buffer_.accessor(weights, "VEC4", 4)}};
    primitive["indices"] = buffer_.accessor(corners, "SCALAR", 1);
    return primitive;
  }

  void add_body() {
    std::vector<float> points, weights;
    std::vector<std::uint16_t> corners;
    std::vector<std::uint8_t> joints;
    add_tube(points, corners, bound_[hips][12], bound_[hips][13] - 0.5, bound_[hips][14], 0.4, 1.5, 9);
    add_weights(points, bound_[hips][13] - 0.25, bound_[neck][13], 3, joints, weights);
    const int skin = add_skin({hips, spine, neck}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    json["meshes"].push_back(
        {{"name", "body"}, {"primitives", {skinned_mesh(body_mesh, skin, points, corners, joints, weights)}}});
  }

  // In hundredths of a metre, turned.
  void add_head() {
    std::vector<float> points, weights;
    std::vector<std::uint16_t> corners;
    std::vector<std::uint8_t> joints;
    add_tube(points, corners, bound_[head][12], bound_[head][13] - 0.5, bound_[head][14], 0.3, 1, 12);
    add_weights(points, bound_[neck][13], bound_[head][13] + 0.1, 2, joints, weights);
    for (std::uint8_t& joint : joints) joint = std::uint8_t(joint == 0 ? 1 : 0);  // the head is first in its skin
    for (std::size_t i = 0; i < joints.size(); i += 4) joints[i + 2] = joints[i + 3] = 0;
    const Matrix map = {0.01, 0, 0, 0, 0, 0, 0.01, 0, 0, -0.01, 0, 0, 0.5, 0.25, -0.125, 1}, back = inverse(map);
    for (std::size_t i = 0; i < points.size(); i += 3) {
      const double x = double(points[i]), y = double(points[i + 1]), z = double(points[i + 2]);
      for (std::size_t k = 0; k < 3; ++k)
        points[i + k] = float(back[k] * x + back[4 + k] * y + back[8 + k] * z + back[12 + k]);
    }
    const int skin = add_skin({head, neck}, map);
    nlohmann::json primitive = skinned_mesh(head_mesh, skin, points, corners, joints, weights);
    for (std::size_t t = 0; t < targets.size(); ++t) {
      std::vector<float> moves;
      for (std::size_t v = 0; v < points.size() / 3; ++v) {
        const float share = 5 * std::sin(0.7f * float(v) + float(t)) + 5;
        moves.insert(moves.end(), {t == 0 ? 0 : share, t == 0 ? share : 0, t == 0 ? 2 * share : -share});
      }
      primitive["targets"].push_back({{"POSITION", buffer_.accessor(moves, "VEC3", 3)}});
    }
    json["meshes"].push_back({{"name", "head"}, {"primitives", {primitive}}, {"extras", {{"targetNames", targets}}}});
  }

  void add_eye() {
    std::vector<float> points;
    std::vector<std::uint16_t> corners;
    add_tube(points, corners, 0, 0, 0, 0.125, 0.25, 3);
    nlohmann::json primitive;
    primitive["attributes"]["POSITION"] = buffer_.accessor(points, "VEC3", 3);
    primitive["indices"] = buffer_.accessor(corners, "SCALAR", 1);
    json["nodes"][eye_mesh]["mesh"] = json["meshes"].size();
    json["meshes"].push_back({{"name", "eye"}, {"primitives", {primitive}}});
  }

  void add_animation() {
    std::vector<float> times, weights;
    std::vector<float> moves[nodes], turns[nodes];
    for (std::size_t f = 0; f < frames; ++f) {
      times.push_back(float(f) / 30);
      for (std::size_t t = 0; t < targets.size(); ++t) weights.push_back(float(weight(t, f)));
      for (std::size_t n = hips; n <= eye_joint; ++n) {
        const Local here = local(n, f);
        for (const double x : here.move) moves[n].push_back(float(x));
        for (const double x : quaternion(here)) turns[n].push_back(float(x));
      }
    }
    const int input = buffer_.accessor(times, "SCALAR", 1);
    nlohmann::json animation = {{"name", "walk"}};
    const auto add = [&](int node, const char* path, int output) {
      animation["channels"].push_back(
          {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
      animation["samplers"].push_back({{"input", input}, {"output", output}});
    };
    add(head_mesh, "weights", buffer_.accessor(weights, "SCALAR", 1));
    for (int n = hips; n <= eye_joint; ++n) {
      add(n, "translation", buffer_.accessor(moves[n], "VEC3", 3));
      add(n, "rotation", buffer_.accessor(turns[n], "VEC4", 4));
    }
    json["animations"] = nlohmann::json::array({animation});  // clang takes {animation} for a copy
  }

  GltfBuffer buffer_;
  std::vector<Matrix> bound_;
};

}  // namespace fb::test
