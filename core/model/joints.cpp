#include "model/joints.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_set>

#include "base/status.h"
#include "model/mesh.h"

namespace fb {
namespace {

constexpr float sum_tolerance = 1e-3f;

bool is_finite(const Frame<float>& frame) {
  return std::all_of(frame.begin(), frame.end(), [](float value) { return std::isfinite(value); });
}

void check_joints(std::span<const Joint> joints) {
  if (joints.size() > most_joints)
    fail(Status::limit, "%zu joints; a face has at most %zu", joints.size(), most_joints);
  std::unordered_set<std::string_view> names;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    if (joint.name.empty()) fail(Status::bad_data, "joint %zu has no name", j);
    if (!names.insert(joint.name).second) fail(Status::bad_data, "two joints named \"%s\"", joint.name.c_str());
    if (joint.parent != no_joint && joint.parent >= j)
      fail(Status::bad_data, "joint \"%s\" has the number %zu and its parent %u; parents come first",
           joint.name.c_str(), j, joint.parent);
    if (!is_finite(joint.rest) || !is_finite(joint.inverse_bind))
      fail(Status::not_finite, "joint \"%s\" has a matrix that is not finite", joint.name.c_str());
  }
}

// Gives whether the vertex follows any joint.
bool check_influences(const Skin& skin, std::size_t vertex, std::size_t joints, bool partly) {
  float sum = 0;
  bool ended = false;
  for (std::size_t i = vertex * skin.influences; i < (vertex + 1) * skin.influences; ++i) {
    const float weight = skin.weights[i];
    if (!std::isfinite(weight) || weight < 0)
      fail(Status::bad_data, "vertex %zu follows a joint by the weight %g", vertex, double(weight));
    if (skin.joints[i] >= joints)
      fail(Status::bad_data, "vertex %zu follows joint %u of %zu", vertex, unsigned{skin.joints[i]}, joints);
    if (ended && weight > 0) fail(Status::bad_data, "vertex %zu has a joint after one of weight 0", vertex);
    ended = weight == 0;
    sum += weight;
  }
  if (sum != 0 && !(sum <= 1 + sum_tolerance && (partly || sum >= 1 - sum_tolerance)))
    fail(Status::bad_data, "vertex %zu has weights of joints that sum to %g, %s", vertex, double(sum),
         partly ? "more than 1" : "not 1");
  return sum != 0;
}

void check_skin(const Skin& skin, std::size_t joints, const Mesh& rest, bool partly) {
  if (skin.influences == 0) {
    if (!skin.joints.empty() || !skin.weights.empty()) fail(Status::bad_data, "a skin without influences");
    return;
  }
  const std::size_t vertices = rest.surface_vertex_count();
  if (skin.influences > most_influences)
    fail(Status::limit, "vertices that follow %u joints; they may follow %u", skin.influences, most_influences);
  if (skin.joints.size() != vertices * skin.influences || skin.weights.size() != skin.joints.size())
    fail(Status::bad_data, "a skin of %zu joints and %zu weights for %zu vertices that follow %u each",
         skin.joints.size(), skin.weights.size(), vertices, skin.influences);
  std::size_t part = 0, first = 0, end = rest.parts.empty() ? vertices : rest.parts[0].vertices;
  bool follows = false;
  for (std::size_t v = 0; v < vertices; ++v) {
    if (v == end) first = v, end += rest.parts[++part].vertices;
    const bool here = check_influences(skin, v, joints, partly);
    if (v > first && here != follows && !partly)
      fail(Status::bad_data, "vertex %zu follows %s, unlike the vertices before it in its mesh", v,
           here ? "a joint" : "no joint");
    follows = here;
  }
}

}  // namespace

std::size_t Skin::count(std::size_t vertex) const {
  std::size_t count = 0;
  while (count < influences && weights[vertex * influences + count] > 0) ++count;
  return count;
}

Frame<double> product(const Frame<double>& a, const Frame<double>& b) {
  Frame<double> c = {};
  for (std::size_t row = 0; row < 12; row += 4) {
    for (std::size_t column = 0; column < 4; ++column)
      for (std::size_t k = 0; k < 3; ++k) c[row + column] += a[row + k] * b[4 * k + column];
    c[row + 3] += a[row + 3];
  }
  return c;
}

std::optional<Frame<double>> inverse(const Frame<double>& f) {
  // By cofactors. A matrix is singular where its volume is nothing beside the lengths of its rows.
  constexpr double least_volume = 1e-9;
  Frame<double> i = {};
  double volume = 1, determinant = 0;
  for (std::size_t row = 0; row < 3; ++row) {
    const std::size_t a = 4 * ((row + 1) % 3), b = 4 * ((row + 2) % 3);
    for (std::size_t column = 0; column < 3; ++column) {
      const std::size_t c = (column + 1) % 3, d = (column + 2) % 3;
      i[4 * column + row] = f[a + c] * f[b + d] - f[a + d] * f[b + c];
    }
    volume *= std::sqrt(f[4 * row] * f[4 * row] + f[4 * row + 1] * f[4 * row + 1] + f[4 * row + 2] * f[4 * row + 2]);
  }
  for (std::size_t column = 0; column < 3; ++column) determinant += f[column] * i[4 * column];
  if (!(std::fabs(determinant) > least_volume * volume) || !std::isfinite(determinant) || !(1 / determinant != 0))
    return std::nullopt;
  for (std::size_t row = 0; row < 12; row += 4) {
    for (std::size_t column = 0; column < 3; ++column) i[row + column] /= determinant;
    i[row + 3] = -(i[row] * f[3] + i[row + 1] * f[7] + i[row + 2] * f[11]);
  }
  if (!std::all_of(i.begin(), i.end(), [](double value) { return std::isfinite(value); })) return std::nullopt;
  return i;
}

Frame<double> to_double(const Frame<float>& frame) {
  Frame<double> converted;
  std::copy(frame.begin(), frame.end(), converted.begin());
  return converted;
}

Frame<float> to_float(const Frame<double>& frame) {
  Frame<float> converted;
  std::transform(frame.begin(), frame.end(), converted.begin(), [](double value) { return static_cast<float>(value); });
  return converted;
}

std::vector<Frame<double>> rest_frames(std::span<const Joint> joints) {
  std::vector<Frame<double>> frames;
  for (const Joint& joint : joints) {
    const Frame<double> local = to_double(joint.rest);
    frames.push_back(joint.parent < frames.size() ? product(frames[joint.parent], local) : local);
  }
  return frames;
}

void set_default_inverse_bind(std::vector<Joint>& joints) {
  const std::vector<Frame<double>> frames = rest_frames(joints);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    Frame<float>& bind = joints[j].inverse_bind;
    if (std::any_of(bind.begin(), bind.end(), [](float value) { return value != 0; })) continue;
    const auto inverted = inverse(frames[j]);
    if (!inverted)
      fail(Status::bad_data, "joint \"%s\" has no inverse bind matrix, and its frame at rest cannot be inverted",
           joints[j].name.c_str());
    bind = to_float(*inverted);
  }
}

void tidy(Skin& skin) {
  const std::size_t width = skin.influences, vertices = width == 0 ? 0 : skin.weights.size() / width;
  std::size_t most = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    std::size_t kept = v * width;
    for (std::size_t i = kept; i < (v + 1) * width; ++i) {
      if (skin.weights[i] == 0) continue;
      std::size_t at = v * width;
      while (at < kept && skin.joints[at] != skin.joints[i]) ++at;
      if (at < kept) {
        skin.weights[at] += skin.weights[i];
        continue;
      }
      skin.joints[kept] = skin.joints[i];
      skin.weights[kept++] = skin.weights[i];
    }
    most = std::max(most, kept - v * width);
    for (; kept < (v + 1) * width; ++kept) skin.joints[kept] = 0, skin.weights[kept] = 0;
  }
  Skin tidied{static_cast<std::uint32_t>(most), {}, {}};
  for (std::size_t v = 0; v < vertices; ++v)
    for (std::size_t i = v * width; i < v * width + most; ++i) {
      tidied.joints.push_back(skin.joints[i]);
      tidied.weights.push_back(skin.weights[i]);
    }
  skin = std::move(tidied);
}

void check(std::span<const Joint> joints, const Skin& skin, const Mesh& rest, bool partly) {
  check_joints(joints);
  check_skin(skin, joints.size(), rest, partly);
}

}  // namespace fb
