#include "bake/export/onnx_driven_joints.h"

#include <algorithm>
#include <numeric>

#include "base/checked.h"
#include "model/joint_rotation.h"

namespace fb::bake {
namespace {

const std::string joints_label = "joints", skin_label = "skin";

// Tensors [n, joints or vertices, columns, 3 rows].
const OnnxAttribute along_joints{"axis", {1}}, along_matrix_columns{"axis", {2}}, along_matrix_rows{"axis", {3}};

using Indices = std::vector<std::uint32_t>;

std::string gather(OnnxGraph& graph, const std::string& label, const std::string& tensor, const Indices& indices,
                   const OnnxAttribute& axis) {
  return graph.node("Gather", label, {tensor, graph.indices(label, indices)}, {axis});
}

// Joints or vertices in the order that their numbers in `listed` give them.
std::string put_in_order(OnnxGraph& graph, const std::string& label, const std::vector<std::string>& parts,
                         const Indices& listed) {
  const std::string all = parts.size() == 1 ? parts[0] : graph.node("Concat", label, parts, {along_joints});
  if (std::ranges::is_sorted(listed)) return all;
  Indices places(listed.size());
  for (std::uint32_t place = 0; place < listed.size(); ++place) places[listed[place]] = place;
  return gather(graph, label, all, places, along_joints);
}

// Column k of a times row k of b.
std::string product_term(OnnxGraph& graph, const std::string& label, const std::string& a, const std::string& b,
                         std::uint32_t k) {
  return graph.node(
      "Mul", label,
      {gather(graph, label, a, {k}, along_matrix_columns), gather(graph, label, b, {k}, along_matrix_rows)});
}

// The first three columns of a times all columns of b: (a0 b0 + a1 b1) + a2 b2.
std::string matrix_product(OnnxGraph& graph, const std::string& label, const std::string& a, const std::string& b) {
  const std::string first = product_term(graph, label, a, b, 0), second = product_term(graph, label, a, b, 1);
  return graph.node("Add", label, {graph.node("Add", label, {first, second}), product_term(graph, label, a, b, 2)});
}

// A change by b within one by a: (a + b) + a b.
std::string composed(OnnxGraph& graph, const std::string& label, const std::string& a, const std::string& b) {
  return graph.node("Add", label, {graph.node("Add", label, {a, b}), matrix_product(graph, label, a, b)});
}

Indices all_joints(const DrivenJoints& driven) {
  Indices joints(driven.joints.size());
  std::iota(joints.begin(), joints.end(), 0);
  return joints;
}

bool any_has(const std::vector<DrivenJoint>& joints, std::uint32_t numbers) {
  return std::ranges::any_of(joints, [&](const DrivenJoint& joint) { return (joint.numbers & numbers) != 0; });
}

// Columns `first` to `last` of the frames of joints at rest, [1, joints, columns, 3].
std::string rest_columns(OnnxGraph& graph, const DrivenJoints& driven, const Indices& joints, std::size_t first,
                         std::size_t last) {
  std::vector<float> values;
  for (const std::uint32_t j : joints)
    for (std::size_t column = first; column <= last; ++column)
      for (std::size_t row = 0; row < 3; ++row) values.push_back(driven.joints[j].rest[4 * row + column]);
  return graph.floats("joints/rest", values,
                      {1, static_cast<std::int64_t>(joints.size()), std::int64_t(last - first + 1), 3});
}

// Numbers of joints as vectors of three; 0 those that a joint does not have.
struct CarriedVectors {
  Indices joints, coordinates;
  std::vector<float> scales;
};
struct JointVectors {
  CarriedVectors own;    // of all joints: rotations, translations, lengths, and pivots if any joint has one
  CarriedVectors outer;  // outer rotations, joint after joint; then one of 0
  // For all first outer rotations, all second ones, ...: which it is of each joint, counted behind the joints' own
  // rotations; of those that have fewer, that of 0.
  std::vector<Indices> rounds;
};

JointVectors joint_vectors(const Mesh& mesh) {
  const std::vector<DrivenJoint>& joints = mesh.driven.joints;
  std::uint32_t coordinate = checked_u32(mesh.first_joint_coordinate(), "coordinates");
  const float* scale = mesh.driven.scales.data();
  const auto take = [&](CarriedVectors& to, std::uint32_t which, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n) {
      const bool has = which >> n & 1;
      to.coordinates.push_back(has ? coordinate++ : 0);
      to.scales.push_back(has ? *scale++ : 0);
    }
  };
  const std::size_t own_numbers = any_has(joints, joint_pivot) ? 12 : 9;
  JointVectors vectors;
  vectors.own.joints = all_joints(mesh.driven);
  for (std::uint32_t j = 0; j < joints.size(); ++j) {
    const std::vector<std::uint8_t>& rotations = joints[j].outer_rotations;
    take(vectors.own, joints[j].numbers, own_numbers);
    for (const std::uint8_t rotation : rotations) take(vectors.outer, rotation, 3);
    vectors.outer.joints.insert(vectors.outer.joints.end(), rotations.size(), j);
    vectors.rounds.resize(std::max(vectors.rounds.size(), rotations.size()));
  }
  auto place = static_cast<std::uint32_t>(joints.size());
  const auto none = static_cast<std::uint32_t>(place + vectors.outer.joints.size());
  for (const DrivenJoint& joint : joints)
    for (std::size_t round = 0; round < vectors.rounds.size(); ++round)
      vectors.rounds[round].push_back(round < joint.outer_rotations.size() ? place++ : none);
  vectors.outer.joints.push_back(0);
  take(vectors.outer, 0, 3);
  return vectors;
}

// Their values [n, joints, vectors of each, 3].
std::string vector_values(OnnxGraph& graph, const std::string& points, const CarriedVectors& vectors) {
  const auto count = static_cast<std::int64_t>(vectors.scales.size()),
             joints = static_cast<std::int64_t>(vectors.joints.size());
  const std::string carried = gather(graph, "joints/numbers", points, vectors.coordinates, along_joints);
  const std::string numbers =
      graph.node("Mul", "joints/numbers", {carried, graph.floats("joints/scales", vectors.scales, {1, count})});
  const std::int64_t shape[] = {0, joints, count / joints / 3, 3};
  return graph.node("Reshape", "joints/numbers", {numbers, graph.integers("shape", shape)});
}

// The rotations [n, count, 3, 3] about vectors [n, count, 1, 3], less the identity.
std::string rotation_changes(OnnxGraph& graph, const std::string& vector, std::size_t count) {
  const std::string label = "joints/rotation";
  const auto node = [&](const char* type, const std::vector<std::string>& inputs) {
    return graph.node(type, label, inputs);
  };
  const auto pick = [&](const std::string& from, const Indices& rows) {
    return gather(graph, label, from, rows, along_matrix_rows);
  };
  const std::string squares = node("Mul", {vector, vector});
  const std::string square = node("Add", {node("Add", {pick(squares, {0}), pick(squares, {1})}), pick(squares, {2})}),
                    angle = node("Min", {square, graph.number(label, most_squared_angle)});
  // -(yy + zz), -(xx + zz), -(xx + yy), xy, xz, yz; then by the columns of the matrix.
  const std::string diagonal = node("Neg", {node("Add", {pick(squares, {1, 0, 0}), pick(squares, {2, 2, 1})})}),
                    beside = node("Mul", {pick(vector, {0, 0, 1}), pick(vector, {1, 2, 2})});
  const std::string even =
      pick(graph.node("Concat", label, {diagonal, beside}, {along_matrix_rows}), {0, 3, 4, 3, 1, 5, 4, 5, 2});
  const float signs[] = {0, 1, -1, -1, 0, 1, 1, -1, 0};
  const std::string odd = node("Mul", {pick(vector, {0, 2, 1, 2, 0, 0, 1, 0, 0}), graph.floats(label, signs, {9})});
  const std::string change = node("Add", {node("Mul", {graph.polynomial(label, angle, rotation_cosine), even}),
                                          node("Mul", {graph.polynomial(label, angle, rotation_sine), odd})});
  const std::int64_t shape[] = {0, static_cast<std::int64_t>(count), 3, 3};
  return node("Reshape", {change, graph.integers("shape", shape)});
}

// How much longer joints are along their axes at rest [n, joints, 3, 3].
std::string joint_lengths(OnnxGraph& graph, const DrivenJoints& driven, const std::string& numbers) {
  const std::string label = "joints/lengths", lengths = gather(graph, label, numbers, {2}, along_matrix_columns);
  std::string sum;
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    std::vector<float> squares;  // of the axis: its outer product with itself
    for (const DrivenJoint& joint : driven.joints)
      for (std::size_t column = 0; column < 3; ++column)
        for (std::size_t row = 0; row < 3; ++row)
          squares.push_back(joint.rest[4 * row + axis] * joint.rest[4 * column + axis]);
    const std::string along =
        graph.node("Mul", label,
                   {gather(graph, label, lengths, {axis}, along_matrix_rows),
                    graph.floats("joints/axes", squares, {1, static_cast<std::int64_t>(driven.joints.size()), 3, 3})});
    sum = sum.empty() ? along : graph.node("Add", label, {sum, along});
  }
  return sum;
}

// How joints are rotated [n, joints, 3, 3], less the identity, about these vectors [n, joints, 1, 3] and then about
// those of their outer rotations. All rotations are found at once.
std::string joint_rotations(OnnxGraph& graph, const DrivenJoints& driven, const JointVectors& vectors,
                            const std::string& first, const std::string& points) {
  const std::size_t joints = driven.joints.size();
  if (vectors.rounds.empty()) return rotation_changes(graph, first, joints);
  const std::string label = "joints/rotation", axes = rest_columns(graph, driven, vectors.outer.joints, 0, 2);
  const std::string outer = matrix_product(graph, label, axes, vector_values(graph, points, vectors.outer));
  const std::string all = rotation_changes(graph, graph.node("Concat", label, {first, outer}, {along_joints}),
                                           joints + vectors.outer.joints.size());
  std::string turned = gather(graph, label, all, vectors.own.joints, along_joints);
  for (const Indices& round : vectors.rounds)
    turned = composed(graph, label, gather(graph, label, all, round, along_joints), turned);
  return turned;
}

// What joints do to what they carry, apart from their parents, [n, joints, 4, 3]: the matrices E.
std::string own_changes(OnnxGraph& graph, const Mesh& mesh, const std::string& points) {
  const DrivenJoints& driven = mesh.driven;
  const JointVectors vectors = joint_vectors(mesh);
  const Indices& joints = vectors.own.joints;
  const std::string numbers = vector_values(graph, points, vectors.own),
                    axes = rest_columns(graph, driven, joints, 0, 2);
  const auto along_axes = [&](std::uint32_t kind) {
    return matrix_product(graph, joints_label, axes,
                          gather(graph, joints_label, numbers, {kind}, along_matrix_columns));
  };
  const std::string rotated = joint_rotations(graph, driven, vectors, along_axes(0), points);
  std::string turned = rotated;
  if (any_has(driven.joints, joint_scale))
    turned = composed(graph, joints_label, turned, joint_lengths(graph, driven, numbers));
  const std::string origins = matrix_product(graph, joints_label, turned, rest_columns(graph, driven, joints, 3, 3));
  std::string moved = along_axes(1);
  if (any_has(driven.joints, joint_pivot))
    moved = graph.node("Sub", joints_label, {moved, matrix_product(graph, joints_label, rotated, along_axes(3))});
  moved = graph.node("Sub", joints_label, {moved, origins});
  return graph.node("Concat", joints_label, {turned, moved}, {along_matrix_columns});
}

// Joints by the number of joints above them.
std::vector<Indices> joint_depths(const std::vector<DrivenJoint>& joints) {
  std::vector<Indices> levels;
  std::vector<std::size_t> depths;
  for (std::uint32_t j = 0; j < joints.size(); ++j) {
    depths.push_back(joints[j].parent == no_joint ? 0 : depths[joints[j].parent] + 1);
    levels.resize(std::max(levels.size(), depths[j] + 1));
    levels[depths[j]].push_back(j);
  }
  return levels;
}

// What takes vertices along that follow so many joints each.
std::string blended_changes(OnnxGraph& graph, const Skin& skin, const Indices& vertices, std::size_t influences,
                            const std::string& changes) {
  std::string sum;
  for (std::size_t i = 0; i < influences; ++i) {
    Indices joints;
    std::vector<float> weights;
    for (const std::uint32_t v : vertices) {
      joints.push_back(skin.joints[std::size_t(v) * skin.influences + i]);
      weights.push_back(skin.weights[std::size_t(v) * skin.influences + i]);
    }
    const auto count = static_cast<std::int64_t>(weights.size());
    const std::string part = graph.node("Mul", skin_label,
                                        {gather(graph, skin_label, changes, joints, along_joints),
                                         graph.floats("skin/weights", weights, {1, count, 1, 1})});
    sum = sum.empty() ? part : graph.node("Add", skin_label, {sum, part});
  }
  return sum;
}

// Positions moved by a matrix each: p + ((b0 x + b1 y) + (b2 z + b3)).
std::string moved_positions(OnnxGraph& graph, const std::string& positions, const std::string& matrices) {
  const auto term = [&](std::uint32_t k) { return product_term(graph, skin_label, matrices, positions, k); };
  const std::string xy = graph.node("Add", skin_label, {term(0), term(1)});
  const std::string last = gather(graph, skin_label, matrices, {3}, along_matrix_columns);
  const std::string z1 = graph.node("Add", skin_label, {term(2), last});
  return graph.node("Add", skin_label, {positions, graph.node("Add", skin_label, {xy, z1})});
}

}  // namespace

std::string add_joint_changes(OnnxGraph& graph, const Mesh& mesh, const std::string& points) {
  const std::vector<DrivenJoint>& joints = mesh.driven.joints;
  const std::string own = own_changes(graph, mesh, points);
  Indices places(joints.size()), listed;  // places: of each joint within its level
  std::vector<std::string> levels;
  for (const Indices& level : joint_depths(joints)) {
    Indices parents;
    for (std::uint32_t place = 0; place < level.size(); ++place) {
      places[level[place]] = place;
      if (!levels.empty()) parents.push_back(places[joints[level[place]].parent]);
    }
    std::string changes = level.size() == joints.size() ? own : gather(graph, joints_label, own, level, along_joints);
    if (!levels.empty())
      changes =
          composed(graph, joints_label, gather(graph, joints_label, levels.back(), parents, along_joints), changes);
    levels.push_back(changes);
    listed.insert(listed.end(), level.begin(), level.end());
  }
  return put_in_order(graph, joints_label, levels, listed);
}

std::string add_joint_frames(OnnxGraph& graph, const DrivenJoints& driven, const std::string& changes) {
  const std::string label = "joints/frames", rest = rest_columns(graph, driven, all_joints(driven), 0, 3);
  const float last[] = {0, 0, 0, 1};
  const std::string shifts = graph.node("Mul", label, {changes, graph.floats(label, last, {4, 1})});
  const std::string moved = graph.node("Add", label, {matrix_product(graph, label, changes, rest), shifts});
  return graph.node("Transpose", label, {graph.node("Add", label, {rest, moved})}, {{"perm", {0, 1, 3, 2}, true}});
}

std::string add_driven_skin(OnnxGraph& graph, const Mesh& mesh, const std::string& positions,
                            const std::string& changes, std::uint64_t& parameters) {
  const Skin& skin = mesh.driven.skin;
  std::vector<Indices> vertices(skin.influences + 1);  // by how many joints they follow
  for (std::uint32_t v = 0; v < mesh.surface_vertex_count(); ++v) vertices[skin.count(v)].push_back(v);
  std::vector<std::string> parts;
  Indices listed;
  for (std::size_t influences = 0; influences < vertices.size(); ++influences) {
    const Indices& some = vertices[influences];
    if (some.empty()) continue;
    std::string part = gather(graph, skin_label, positions, some, along_joints);
    if (influences > 0) part = moved_positions(graph, part, blended_changes(graph, skin, some, influences, changes));
    parts.push_back(part);
    listed.insert(listed.end(), some.begin(), some.end());
    parameters += influences * some.size();
  }
  return put_in_order(graph, skin_label, parts, listed);
}

}  // namespace fb::bake
