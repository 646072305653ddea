#include "uv_chart.h"

#include <algorithm>
#include <utility>

namespace sample_face {

Chart::Chart(const FaceMesh& mesh, std::vector<Index> quads, const Ring& seam) : quads_(std::move(quads)) {
  const auto point_of = [&](std::unordered_map<Index, Index>& points, Index vertex) {
    const auto [found, added] = points.emplace(vertex, Index(places_.size()));
    if (added) places_.push_back(mesh.points[vertex]);
    return found->second;
  };
  for (const Index quad : quads_) {
    float side = 0;
    for (const Index v : mesh.quads[quad]) side += mesh.points[v].x;
    std::array<Index, 4>& corners = corners_.emplace_back();
    for (int i = 0; i < 4; ++i) {
      const Index v = mesh.quads[quad][i];
      // The last vertex of the seam is where it ends: both sides have it.
      const bool copy = side < 0 && !seam.empty() && v != seam.back() && std::ranges::count(seam, v) > 0;
      corners[i] = point_of(copy ? copies_ : points_, v);
    }
  }
  at_.resize(places_.size());
  placed_.resize(places_.size(), false);
  links_.resize(places_.size());
  for (const auto& corners : corners_)
    for (int i = 0; i < 4; ++i) link(corners[i], corners[(i + 1) % 4]);
}

void Chart::link(Index a, Index b) {
  const float weight = 1 / std::max(length(places_[a] - places_[b]), 1e-3f);
  for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
    if (std::ranges::none_of(links_[from], [end = to](const Link& l) { return l.to == end; }))
      links_[from].push_back({to, weight});
}

void Chart::place(Index point, Uv at) {
  at_[point] = at;
  placed_[point] = true;
}

void Chart::start(const std::function<Uv(Vec3)>& at) {
  for (std::size_t p = 0; p < at_.size(); ++p)
    if (!placed_[p]) at_[p] = at(places_[p]);
}

void Chart::add_hole(const Ring& ring) {
  const Index middle = Index(places_.size());
  Vec3 centre;
  Uv start;
  for (const Index v : ring) {
    const Index p = point(v);
    centre += places_[p] * (1 / float(ring.size()));
    start = {start.u + at_[p].u / float(ring.size()), start.v + at_[p].v / float(ring.size())};
  }
  places_.push_back(centre);
  at_.push_back(start);
  placed_.push_back(false);
  links_.emplace_back();
  for (const Index v : ring) link(middle, point(v));
}

void Chart::solve(int sweeps) {
  constexpr float kOver = 1.7f;  // successive over-relaxation
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (std::size_t p = 0; p < at_.size(); ++p) {
      if (placed_[p]) continue;
      Uv sum;
      float weights = 0;
      for (const Link& l : links_[p]) {
        sum = {sum.u + l.weight * at_[l.to].u, sum.v + l.weight * at_[l.to].v};
        weights += l.weight;
      }
      at_[p] = {mix(at_[p].u, sum.u / weights, kOver), mix(at_[p].v, sum.v / weights, kOver)};
    }
}

// By point, the root of the mean square of how much larger the triangles at it are on the surface than in the chart,
// along both axes (Sander et al., "Texture mapping progressive meshes", 2001).
std::vector<float> Chart::stretches(const std::function<float(Vec3)>& scale) const {
  std::vector<float> squares(at_.size(), 0), areas(at_.size(), 0);
  for (const auto& corners : corners_)
    for (int i = 0; i < 4; ++i) {
      const Index a = corners[(i + 3) % 4], b = corners[i], c = corners[(i + 1) % 4];
      const float larger = scale(places_[b]);
      const Vec3 p = (places_[a] - places_[b]) * larger, q = (places_[c] - places_[b]) * larger;
      const Uv s{at_[a].u - at_[b].u, at_[a].v - at_[b].v}, t{at_[c].u - at_[b].u, at_[c].v - at_[b].v};
      const float flat = std::max(std::fabs(s.u * t.v - s.v * t.u), 1e-9f), area = length(cross(p, q));
      const Vec3 along_u = (p * t.v - q * s.v) * (1 / flat), along_v = (q * s.u - p * t.u) * (1 / flat);
      const float square = 0.5f * (dot(along_u, along_u) + dot(along_v, along_v));
      for (const Index point : {a, b, c}) {
        squares[point] += area * square;
        areas[point] += area;
      }
    }
  for (std::size_t p = 0; p < squares.size(); ++p)
    if (areas[p] > 0) squares[p] = std::sqrt(squares[p] / areas[p]);
  for (std::size_t p = 0; p < squares.size(); ++p)
    if (areas[p] == 0)  // the middle of a hole is as large as what is round it
      for (const Link& l : links_[p]) squares[p] += squares[l.to] / float(links_[p].size());
  return squares;
}

void Chart::relax(int passes, int sweeps, const std::function<float(Vec3)>& scale) {
  solve(sweeps);
  for (int pass = 0; pass < passes; ++pass) {
    const std::vector<float> stretch = stretches(scale);
    for (std::vector<Link>& links : links_) {
      float sum = 0;
      for (Link& l : links) {
        l.weight /= stretch[l.to];
        sum += l.weight;
      }
      for (Link& l : links) l.weight /= sum;
    }
    solve(sweeps);
  }
}

void Chart::add_to(FaceUvs& uvs) const {
  const Index first = Index(uvs.pairs.size());
  uvs.pairs.insert(uvs.pairs.end(), at_.begin(), at_.begin() + std::ptrdiff_t(points_.size() + copies_.size()));
  for (std::size_t q = 0; q < quads_.size(); ++q)
    for (int i = 0; i < 4; ++i) uvs.corners[quads_[q]][i] = first + corners_[q][i];
}

}  // namespace sample_face
