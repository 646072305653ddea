#include "solve/mesh_correspondence.h"

#include <algorithm>
#include <numeric>

#include "base/length_units.h"
#include "base/status.h"
#include "base/surface.h"

namespace fb::tool {
namespace {

constexpr double median_multiple = 3, least_bound = 0.01;

// Of values, in any order; 0 without any.
double quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(at));
  return values[at];
}

std::vector<std::uint32_t> asked_vertices(const CorrespondenceOptions& options, std::size_t count) {
  std::vector<std::uint32_t> vertices = options.vertices;
  if (vertices.empty()) {
    vertices.resize(count);
    std::iota(vertices.begin(), vertices.end(), 0u);
  }
  for (const std::uint32_t v : vertices)
    if (v >= count) fail(Status::invalid_argument, "vertex %u of the face: it has %zu vertices", v, count);
  return vertices;
}

}  // namespace

MeshCorrespondence find_correspondence(const SampledSurface& face, const SampledSurface& other,
                                       const Similarity& to_face, const CorrespondenceOptions& options) {
  const std::vector<std::uint32_t> asked = asked_vertices(options, face.points.size() / 3);
  const std::vector<Vector3> normals = vertex_normals(face.triangles, face.points);
  const Similarity back = to_face.inverse();
  const auto to_other = static_cast<float>(back.scale), to_this = static_cast<float>(to_face.scale);
  MeshCorrespondence result;
  result.vertices.resize(asked.size());
  std::vector<float> distances(asked.size());
  std::vector<Vector3> moved(asked.size());
  parallel_for(options.parallel, asked.size(), [&](std::size_t i, std::size_t) {
    moved[i] = back(vector_at(face.points.data(), asked[i]));
    Correspondence& found = result.vertices[i];
    found.vertex = asked[i];
    found.partner = Partner::far;
    const auto closest = other.tree.closest(moved[i]);
    if (!closest) return;
    found.other = closest->surface;
    found.distance = distances[i] = closest->distance * to_this;
  });
  result.bound =
      options.bound.value_or(std::max(median_multiple * quantile(distances, 0.5), least_bound * face.diagonal));
  parallel_for(options.parallel, asked.size(), [&](std::size_t i, std::size_t) {
    Correspondence& found = result.vertices[i];
    if (!(found.distance <= result.bound)) return;
    const auto facing = other.tree.closest(moved[i], {.most_distance = static_cast<float>(result.bound) * to_other,
                                                      .normal = normalized(back.turned(normals[found.vertex]))});
    found.partner = Partner::turned;
    if (!facing) return;
    found.other = facing->surface;
    found.distance = facing->distance * to_this;
    found.partner = other.border.has(*facing) ? Partner::border : Partner::found;
  });
  result.statistics = statistics_of(result.vertices);
  return result;
}

CorrespondenceStatistics statistics_of(std::span<const Correspondence> vertices) {
  CorrespondenceStatistics statistics;
  statistics.vertices = vertices.size();
  std::vector<float> distances;
  for (const Correspondence& c : vertices) {
    statistics.far += c.partner == Partner::far;
    statistics.turned += c.partner == Partner::turned;
    statistics.border += c.partner == Partner::border;
    if (c.partner == Partner::found) distances.push_back(c.distance);
  }
  if (!vertices.empty())
    statistics.without = 1 - static_cast<double>(distances.size()) / static_cast<double>(vertices.size());
  statistics.median = quantile(distances, 0.5);
  statistics.p95 = quantile(distances, 0.95);
  statistics.most = quantile(distances, 1);
  return statistics;
}

std::string correspondence_text(const MeshCorrespondence& correspondence, const std::string& unit) {
  const CorrespondenceStatistics& s = correspondence.statistics;
  const std::size_t found = s.vertices - s.far - s.turned - s.border;
  std::string text = format("%zu of %zu vertices have a partner on the target", found, s.vertices);
  if (found > 0)
    text += format(", half of them within %s, 95 %% within %s", length_text(s.median, unit).c_str(),
                   length_text(s.p95, unit).c_str());
  if (found < s.vertices)
    text += format("; of the others, %zu are farther than %s from it, %zu face another way, %zu lie beyond its border",
                   s.far, length_text(correspondence.bound, unit).c_str(), s.turned, s.border);
  return text;
}

}  // namespace fb::tool
