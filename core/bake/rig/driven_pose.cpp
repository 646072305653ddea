#include "bake/rig/driven_pose.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "bake/rig/rotation_vector.h"
#include "base/checked.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double most_angle = 0.95 * pi;

Axis column(const Frame<double>& frame, std::size_t c) {
  return {frame[c], frame[4 + c], frame[8 + c]};
}
double volume_of(const Frame<double>& frame) {
  const Axis x = column(frame, 0), y = column(frame, 1), z = column(frame, 2);
  return dot({x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]}, z);
}

// The rotation of a matrix's polar decomposition; nothing if it has none.
std::optional<Frame<double>> closest_rotation(const Frame<double>& matrix) {
  Frame<double> r = matrix;
  r[3] = r[7] = r[11] = 0;
  for (int step = 0; step < 50; ++step) {
    const auto inverted = inverse(r);
    if (!inverted) return std::nullopt;
    double change = 0;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) {
        const double next = (r[4 * a + b] + (*inverted)[4 * b + a]) / 2;
        change = std::max(change, std::fabs(next - r[4 * a + b]));
        r[4 * a + b] = next;
      }
    if (change < 1e-14) break;
  }
  if (!(volume_of(r) > 0)) return std::nullopt;
  return r;
}

// What a joint's numbers, in their order, do in its own axes.
Frame<double> own_motion(const DrivenJoint& joint, std::span<const double> numbers) {
  double n[numbers_a_joint] = {};
  std::size_t at = 0;
  for (std::size_t k = 0; k < numbers_a_joint; ++k)
    if (joint.numbers >> k & 1) n[k] = numbers[at++];
  Frame<double> own = rotation_about({n[0], n[1], n[2]});
  for (const std::uint8_t rotation : joint.outer_rotations) {
    Axis outer = {};
    for (std::size_t k = 0; k < 3; ++k)
      if (rotation >> k & 1) outer[k] = numbers[at++];
    own = product(rotation_about(outer), own);
  }
  for (std::size_t row = 0; row < 3; ++row) {
    double* const r = &own[4 * row];
    r[3] = n[3 + row] + n[9 + row] - (r[0] * n[9] + r[1] * n[10] + r[2] * n[11]);
    for (std::size_t c = 0; c < 3; ++c) r[c] *= 1 + n[6 + c];
  }
  return own;
}

Frame<double> inverse_rest(const DrivenJoint& joint) {
  const auto back = inverse(to_double(joint.rest));
  if (!back) fail(Status::bad_data, "driven joint \"%s\" has a frame that cannot be inverted", joint.name.c_str());
  return *back;
}

// The motion of a joint in the space of positions, from that of its parent and its own numbers.
Frame<double> motion_of(const DrivenJoint& joint, std::span<const Frame<double>> motions, const Frame<double>& back,
                        std::span<const double> numbers) {
  const Frame<double>& above = joint.parent == no_joint ? still_frame : motions[joint.parent];
  if (std::ranges::all_of(numbers, [](double number) { return number == 0; })) return above;
  const Frame<double> here = product(product(to_double(joint.rest), own_motion(joint, numbers)), back);
  return joint.parent == no_joint ? here : product(above, here);
}

// Numbers that frames of floats cannot tell from 0 are 0, so that what no control moves is still.
double without_noise(double number, std::size_t n, const DrivenJoint& joint) {
  constexpr double noise = 5e-7;
  const bool moves = (joint_translation | joint_pivot) >> n & 1;
  const float size = std::max({std::fabs(joint.rest[3]), std::fabs(joint.rest[7]), std::fabs(joint.rest[11])});
  return std::fabs(number) <= noise * (moves ? double(size) : 1) ? 0 : number;
}

// By vertex: the weights of a joint and of all below it.
std::vector<double> weights_below(const Mesh& rest, std::uint32_t joint) {
  const DrivenJoints& driven = rest.driven;
  std::vector<std::uint8_t> below(driven.joints.size());
  for (std::size_t j = joint; j < below.size(); ++j)
    below[j] = j == joint || (driven.joints[j].parent != no_joint && below[driven.joints[j].parent]);
  std::vector<double> weights(rest.surface_vertex_count());
  for (std::size_t i = 0; i < driven.skin.weights.size(); ++i)
    if (below[driven.skin.joints[i]]) weights[i / driven.skin.influences] += driven.skin.weights[i];
  return weights;
}

// How far a unit of a number moves the vertices that follow its joint: the root of the sum of squares.
double reach_of(const Mesh& rest, const DrivenJoint& joint, std::size_t number, std::span<const double> weights) {
  const Frame<double> frame = to_double(joint.rest);
  const Axis axis = column(frame, number % 3), origin = column(frame, 3);
  double sum = 0;
  for (std::size_t v = 0; v < weights.size(); ++v) {
    Axis offset;
    for (std::size_t a = 0; a < 3; ++a) offset[a] = rest.points[3 * v + a] - origin[a];
    const double along = dot(axis, offset);
    const double squared = joint_rotation >> number & 1 ? std::max(dot(offset, offset) - along * along, 0.0)
                           : joint_scale >> number & 1  ? along * along
                                                        : 1;
    sum += weights[v] * weights[v] * squared;
  }
  return std::sqrt(sum);
}

// Numbers turn and move a joint along the axes of its frame.
void check_axes(const DrivenJoint& joint) {
  const Frame<double> frame = to_double(joint.rest);
  constexpr double tolerance = 1e-4;
  double off = 0;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b)
      off = std::max(off, std::fabs(dot(column(frame, a), column(frame, b)) - (a == b)));
  if (!(off <= tolerance) || !(volume_of(frame) > 0))
    fail(Status::bad_data, "driven joint \"%s\" has axes that are not orthogonal, right-handed and of length 1",
         joint.name.c_str());
}

}  // namespace

std::optional<Frame<double>> straightened(const Frame<double>& frame) {
  Frame<double> right = frame;
  if (volume_of(frame) < 0)
    for (const std::size_t row : {2, 6, 10}) right[row] = -right[row];
  std::optional<Frame<double>> rotation = closest_rotation(right);
  for (std::size_t row = 3; rotation && row < 12; row += 4) (*rotation)[row] = frame[row];
  return rotation;
}

void add_joint_vertices(Mesh& rest) {
  DrivenJoints& driven = rest.driven;
  for (const DrivenJoint& joint : driven.joints) check_axes(joint);
  driven.scales.clear();
  const double least = 1e-3 * rest.diagonal();  // of joints that nothing follows
  for (std::uint32_t j = 0; j < driven.joints.size(); ++j) {
    const std::vector<double> weights = weights_below(rest, j);
    for (const std::uint8_t kind : driven.joints[j].number_kinds())
      driven.scales.push_back(static_cast<float>(1 / std::max(reach_of(rest, driven.joints[j], kind, weights), least)));
  }
  const std::size_t carriers = (driven.scales.size() + 2) / 3;
  rest.carrier_vertices += checked_u32(carriers, "numbers of driven joints");
  rest.points.resize(rest.points.size() + 3 * carriers);
}

void remove_joint_vertices(Mesh& rest) {
  const std::size_t kept = rest.first_joint_coordinate();
  rest.carrier_vertices -= static_cast<std::uint32_t>((rest.points.size() - kept) / 3);
  rest.points.resize(kept);
}

void find_joint_numbers(const DrivenJoints& driven, std::span<const Frame<double>> frames, std::span<float> numbers) {
  std::vector<Frame<double>> motions;
  std::size_t at = 0;
  for (std::size_t j = 0; j < driven.joints.size(); ++j) {
    const DrivenJoint& joint = driven.joints[j];
    const char* const name = joint.name.c_str();
    const Frame<double> back = inverse_rest(joint);
    const auto parent_back = inverse(joint.parent == no_joint ? still_frame : motions[joint.parent]);
    if (!parent_back) fail(Status::bad_data, "the parent of driven joint \"%s\" is flat", name);
    const Frame<double> own = product(back, product(*parent_back, frames[j]));
    const auto rotation = closest_rotation(own);
    if (!rotation) fail(Status::bad_data, "driven joint \"%s\" is mirrored or flat", name);
    Axis turned = rotation_vector(*rotation);
    if (const double angle = std::sqrt(dot(turned, turned)); angle > most_angle)
      for (double& value : turned) value *= most_angle / angle;
    double all[numbers_a_joint] = {turned[0], turned[1], turned[2], own[3], own[7], own[11]};
    for (std::size_t a = 0; a < 3; ++a) all[6 + a] = dot(column(*rotation, a), column(own, a)) - 1;
    std::vector<double> own_numbers;
    for (const std::uint8_t kind : joint.number_kinds()) {
      const bool outer = own_numbers.size() >= static_cast<std::size_t>(std::popcount(joint.numbers));
      numbers[at] = outer ? 0 : static_cast<float>(without_noise(all[kind], kind, joint));
      own_numbers.push_back(numbers[at++]);
    }
    motions.push_back(motion_of(joint, motions, back, own_numbers));
  }
}

std::vector<Frame<double>> joint_motions(const DrivenJoints& driven, std::span<const float> coordinates) {
  std::vector<Frame<double>> motions;
  std::size_t at = 0;
  for (const DrivenJoint& joint : driven.joints) {
    std::vector<double> numbers;
    for (std::size_t n = joint.number_count(); n > 0; --n, ++at)
      numbers.push_back(double(driven.scales[at]) * coordinates[at]);
    motions.push_back(motion_of(joint, motions, inverse_rest(joint), numbers));
  }
  return motions;
}

namespace {

// What a vertex is taken along by: weights x motions, and the rest of its weight as it is.
Frame<double> blend_of(const Skin& skin, std::size_t vertex, std::span<const Frame<double>> motions) {
  Frame<double> blend = still_frame;
  const std::size_t first = vertex * skin.influences;
  for (std::size_t i = first; i < first + skin.influences && skin.weights[i] > 0; ++i) {
    const Frame<double>& motion = motions[skin.joints[i]];
    if (motion == still_frame) continue;
    for (std::size_t k = 0; k < 12; ++k) blend[k] += double(skin.weights[i]) * (motion[k] - still_frame[k]);
  }
  return blend;
}

// See remove_driven_skin; of one vertex of the surface.
void unskin(const Mesh& rest, std::span<const Frame<double>> motions, std::size_t v, std::span<float> points) {
  const Frame<double> blend = blend_of(rest.driven.skin, v, motions);
  if (blend == still_frame) return;
  const auto back = inverse(blend);
  const double at[3] = {points[3 * v], points[3 * v + 1], points[3 * v + 2]};
  for (std::size_t a = 0; a < 3; ++a) {
    const double* const row = back ? back->data() + 4 * a : nullptr;
    points[3 * v + a] =
        row ? static_cast<float>(row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3]) : rest.points[3 * v + a];
  }
}

}  // namespace

void add_driven_skin(const Mesh& rest, std::span<const Frame<double>> motions, std::span<double> positions) {
  for (std::size_t v = 0; v < positions.size() / 3; ++v) {
    const Frame<double> blend = blend_of(rest.driven.skin, v, motions);
    const double x = positions[3 * v], y = positions[3 * v + 1], z = positions[3 * v + 2];
    for (std::size_t a = 0; a < 3; ++a)
      positions[3 * v + a] = blend[4 * a] * x + blend[4 * a + 1] * y + blend[4 * a + 2] * z + blend[4 * a + 3];
  }
}

void remove_driven_skin(const Mesh& rest, std::span<float> points) {
  if (rest.driven.empty()) return;
  const auto motions = joint_motions(rest.driven, points.subspan(rest.first_joint_coordinate()));
  for (std::size_t v = 0; v < rest.surface_vertex_count(); ++v) unskin(rest, motions, v, points);
}

void points_to_displacements(const Mesh& rest, std::span<float> points, std::span<const std::uint32_t> vertices) {
  if (vertices.empty()) {
    remove_driven_skin(rest, points);
    for (std::size_t i = 0; i < rest.points.size(); ++i) points[i] -= rest.points[i];
    return;
  }
  std::vector<Frame<double>> motions;
  if (!rest.driven.empty()) motions = joint_motions(rest.driven, points.subspan(rest.first_joint_coordinate()));
  std::size_t to = 0;
  for (const std::uint32_t v : vertices) {
    if (!motions.empty() && v < rest.surface_vertex_count()) unskin(rest, motions, v, points);
    for (std::size_t i = std::size_t{3} * v; i < std::size_t{3} * v + 3; ++i) points[to++] = points[i] - rest.points[i];
  }
}

}  // namespace fb::bake
