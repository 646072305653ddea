#include "bake/measure/face_map.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "bake/measure/measured_face.h"
#include "bake/measure/vertex_distance.h"

namespace fb::bake {
namespace {

constexpr float still = 1e-5f;       // over D: motion that does not count
constexpr float moved_share = 0.1f;  // of a control's largest motion, see moved_by
constexpr float moving = 2e-3f;      // over D: vertices that move less are not in the box

// The part of the range that a value lies in: 0 to 1.
float share_of(float value, float low, float high) {
  return high > low ? (value - low) / (high - low) : 0.5f;
}

}  // namespace

FaceMap::FaceMap(const PackedModel& model, const Parallel& parallel)
    : schema_(model.schema),
      rest_(model.rest.surface_points().begin(), model.rest.surface_points().end()),
      vertices_(model.rest.surface_vertex_count()) {
  const std::size_t controls = schema_.control_count();
  const double diagonal = model.rest.diagonal();
  MeasuredFace face(model, worker_count(parallel));
  motion_.resize(controls * vertices_);
  squared_motion_.resize(controls);
  parallel_for(parallel, controls, [&](std::size_t c, std::size_t w) {
    std::vector<float> pose = schema_.rest_pose();
    const std::span<float> most = std::span(motion_).subspan(c * vertices_, vertices_);
    for (const float end : {schema_.controls[c].minimum, schema_.controls[c].maximum}) {
      pose[c] = end;
      raise_to_distances(most, face.positions(pose.data(), w), rest_, diagonal);
    }
    for (const float m : most) squared_motion_[c] += double(m) * m;
  });

  std::vector<float> largest(vertices_);
  for (std::size_t c = 0; c < controls; ++c)
    for (std::size_t v = 0; v < vertices_; ++v) largest[v] = std::max(largest[v], motion(c, v));
  std::vector<std::uint32_t> moved;
  for (std::uint32_t v = 0; v < vertices_; ++v)
    if (largest[v] > moving) moved.push_back(v);
  if (moved.empty()) {
    moved.resize(vertices_);
    std::iota(moved.begin(), moved.end(), 0u);
  }
  moving_part_ = box_of(moved);
}

PointBox FaceMap::box_of(std::span<const std::uint32_t> vertices) const {
  PointBox box;
  std::vector<float> values(vertices.size());
  for (float Vector3::*axis : {&Vector3::x, &Vector3::y, &Vector3::z}) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = vector_at(rest_.data(), vertices[i]).*axis;
    std::sort(values.begin(), values.end());
    const std::size_t left_out = values.size() / 20;
    if (values.empty()) continue;
    box.low.*axis = values[left_out];
    box.high.*axis = values[values.size() - 1 - left_out];
  }
  return box;
}

std::string FaceMap::place_in(const PointBox& box, std::span<const std::uint32_t> vertices) const {
  Vector3 sum;
  for (const std::uint32_t v : vertices) sum = sum + vector_at(rest_.data(), v);
  const Vector3 p = sum * (1 / static_cast<float>(std::max<std::size_t>(vertices.size(), 1)));
  const float x = share_of(p.x, box.low.x, box.high.x), y = share_of(p.y, box.low.y, box.high.y),
              z = share_of(p.z, box.low.z, box.high.z);
  const bool z_up = schema_.up_axis == "z";
  const float height = z_up ? z : y, front = z_up ? 1 - y : z;
  std::string place = height > 2 / 3.0f ? "upper " : height < 1 / 3.0f ? "lower " : "";
  place += x > 0.6f ? "left" : x < 0.4f ? "right" : "middle";
  return front < 0.25f ? place + ", at the back" : place;
}

std::vector<std::uint32_t> FaceMap::moved_by(std::size_t control) const {
  const auto row = std::span(motion_).subspan(control * vertices_, vertices_);
  const float enough = std::max(still, moved_share * *std::max_element(row.begin(), row.end()));
  std::vector<std::uint32_t> moved;
  for (std::uint32_t v = 0; v < vertices_; ++v)
    if (row[v] >= enough) moved.push_back(v);
  return moved;
}

// The squared motion of these vertices by each control, over the root of that of all vertices.
std::vector<double> FaceMap::influences(std::span<const std::uint32_t> vertices) const {
  std::vector<double> influences(schema_.control_count());
  for (std::size_t c = 0; c < influences.size(); ++c) {
    for (const std::uint32_t v : vertices)
      if (motion(c, v) > still) influences[c] += double(motion(c, v)) * motion(c, v);
    if (influences[c] > 0) influences[c] /= std::sqrt(squared_motion_[c]);
  }
  return influences;
}

std::vector<std::uint32_t> FaceMap::movers(std::span<const std::uint32_t> vertices, std::size_t at_most) const {
  const std::vector<double> most = influences(vertices);
  std::vector<std::uint32_t> order(most.size());
  std::iota(order.begin(), order.end(), 0u);
  std::erase_if(order, [&](std::uint32_t c) { return most[c] == 0; });
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return most[a] > most[b]; });
  order.resize(std::min(order.size(), at_most));
  return order;
}

std::string FaceMap::group_of(std::span<const std::uint32_t> vertices) const {
  const std::vector<double> most = influences(vertices);
  std::map<std::string, double> groups;
  for (std::size_t c = 0; c < most.size(); ++c) groups[schema_.controls[c].group] += most[c];
  const auto strongest =
      std::max_element(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return strongest == groups.end() || strongest->second == 0 ? "" : strongest->first;
}

std::string FaceMap::name_of(std::uint32_t vertex) const {
  if (vertex >= vertices_) {
    const std::size_t first = 3 * (vertex - vertices_);
    return "channel \"" + schema_.channels[first].name +
           (first + 1 < schema_.channels.size() ? "\" or the next" : "\"");
  }
  const std::string group = group_of(std::span(&vertex, 1)), place = place_in(moving_part_, std::span(&vertex, 1));
  return group.empty() ? place : group + ", " + place;
}

}  // namespace fb::bake
