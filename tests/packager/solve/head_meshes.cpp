#include "head_meshes.h"

#include <algorithm>
#include <map>
#include <utility>

#include "base/random.h"
#include "dense/dense_mesh.h"
#include "rig.h"

namespace fb::test {
namespace {

using Quads = std::vector<std::array<std::uint32_t, 4>>;

std::vector<float> floats_of(const std::vector<sample_face::Vec3>& points) {
  std::vector<float> values;
  for (const sample_face::Vec3& p : points) values.insert(values.end(), {p.x, p.y, p.z});
  return values;
}

const sample_face::Rig& sample_rig() {
  static const sample_face::Rig rig;
  return rig;
}

HeadMesh dual_of(const std::vector<float>& points, const Quads& quads) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> quad_of_edge;
  HeadMesh dual;
  for (std::uint32_t q = 0; q < quads.size(); ++q) {
    float middle[3] = {};
    for (std::size_t k = 0; k < 4; ++k) {
      quad_of_edge[{quads[q][k], quads[q][(k + 1) % 4]}] = q;
      for (std::size_t axis = 0; axis < 3; ++axis) middle[axis] += points[3 * quads[q][k] + axis] / 4;
    }
    dual.points.insert(dual.points.end(), middle, middle + 3);
  }
  std::vector<bool> done(points.size() / 3);
  for (std::uint32_t first = 0; first < quads.size(); ++first)
    for (const std::uint32_t v : quads[first]) {
      if (done[v]) continue;
      done[v] = true;
      std::vector<std::uint32_t> ring;
      for (std::uint32_t q = first;;) {
        ring.push_back(q);
        const auto corner = static_cast<std::size_t>(std::ranges::find(quads[q], v) - quads[q].begin());
        const auto next = quad_of_edge.find({v, quads[q][(corner + 3) % 4]});
        if (next == quad_of_edge.end()) ring.clear();
        if (next == quad_of_edge.end() || next->second == first) break;
        q = next->second;
      }
      if (ring.size() < 3) continue;
      dual.sizes.push_back(static_cast<std::uint32_t>(ring.size()));
      dual.corners.insert(dual.corners.end(), ring.begin(), ring.end());
    }
  return dual;
}

}  // namespace

const HeadMesh& sample_head() {
  static const HeadMesh head = [] {
    HeadMesh mesh;
    mesh.points = floats_of(sample_rig().rest());
    for (const auto& quad : sample_rig().mesh().quads) {
      mesh.sizes.push_back(4);
      mesh.corners.insert(mesh.corners.end(), quad.begin(), quad.end());
    }
    return mesh;
  }();
  return head;
}

HeadMesh dual_head(std::uint32_t divisions) {
  const HeadMesh& head = sample_head();
  const rigs::dense::DenseMesh dense(static_cast<std::uint32_t>(head.points.size() / 3), sample_rig().mesh().quads,
                                     divisions);
  std::vector<float> points(std::size_t{3} * dense.vertices());
  dense.pose(head.points.data(), points.data());
  return dual_of(points, dense.quads());
}

HeadMesh moved(const HeadMesh& mesh, const tool::Similarity& by) {
  HeadMesh other = mesh;
  other.points = by.applied(mesh.points);
  return other;
}

HeadMesh with_noise(HeadMesh mesh, float deviation) {
  Random random(3);
  for (float& value : mesh.points) value += deviation * random.normal();
  return mesh;
}

HeadMesh cut_beyond(const HeadMesh& mesh, float x) {
  HeadMesh cut;
  cut.points = mesh.points;
  std::size_t first = 0;
  for (const std::uint32_t size : mesh.sizes) {
    const auto corners = std::span(mesh.corners).subspan(first, size);
    first += size;
    if (std::ranges::any_of(corners, [&](std::uint32_t v) { return mesh.points[3 * std::size_t{v}] > x; })) continue;
    cut.sizes.push_back(size);
    cut.corners.insert(cut.corners.end(), corners.begin(), corners.end());
  }
  return cut;
}

double largest_error(const HeadMesh& mesh, const tool::Similarity& moved_by, const tool::Similarity& found) {
  double most = 0;
  for (std::size_t v = 0; v < mesh.points.size() / 3; ++v) {
    const Vector3 p = vector_at(mesh.points.data(), v);
    most = std::max(most, double(length(found(moved_by(p)) - p)));
  }
  return most;
}

}  // namespace fb::test
