#include "bake/measure/contact.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

#include "base/surface.h"

namespace fb::bake {
namespace {

constexpr float facing = -0.5f;        // n . n of places that face each other
constexpr float surface_distance = 4;  // over the touching distance: nearer along the surface is one place
constexpr float sheet_share = 0.1f;    // of the touching distance, see ContactFinder
constexpr float shrunk_share = 0.01f;  // of a triangle's area at rest
constexpr float cell_edges = 1.5f;     // size of a cell over the mean edge

// Vertices that are one place of the surface: at the same place at rest, and not facing each other.
std::vector<std::pair<std::uint32_t, std::uint32_t>> seams(const Mesh& rest, std::span<const Vector3> normals) {
  const auto place = [&](std::uint32_t v) {
    return std::array{rest.points[3 * v], rest.points[3 * v + 1], rest.points[3 * v + 2]};
  };
  std::vector<std::uint32_t> order(rest.vertex_count());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::pair(place(a), a) < std::pair(place(b), b); });
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  std::vector<std::uint32_t> apart;  // vertices of a place, all facing each other: three at most
  for (const std::uint32_t v : order) {
    if (!apart.empty() && place(apart[0]) != place(v)) apart.clear();
    const auto same =
        std::find_if(apart.begin(), apart.end(), [&](std::uint32_t a) { return dot(normals[a], normals[v]) > facing; });
    if (same == apart.end())
      apart.push_back(v);
    else
      pairs.emplace_back(*same, v);
  }
  return pairs;
}

Vector3 lowest(Vector3 a, Vector3 b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vector3 highest(Vector3 a, Vector3 b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

template <class At>
Vector3 at_weights(const TouchingPair& pair, At at) {
  return at(pair.corners[0]) * pair.weights[0] + at(pair.corners[1]) * pair.weights[1] +
         at(pair.corners[2]) * pair.weights[2];
}

float mean_edge(const SurfaceGraph& graph) {
  double sum = 0;
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < graph.size(); ++v)
    for (const SurfaceGraph::Edge& edge : graph.edges(v)) {
      sum += edge.length;
      ++count;
    }
  return count > 0 ? static_cast<float>(sum / static_cast<double>(count)) : 0;
}

// Parts of the sphere of directions: 3 x 3 on each side of a cube round it, at 15 degrees from the middle.
constexpr unsigned direction_parts = 54;
constexpr float part_edge = 0.268f;

unsigned direction_part(Vector3 n) {
  const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const auto third = [](float k, float largest) {
    return k < -part_edge * largest ? 0u : k > part_edge * largest ? 2u : 1u;
  };
  const auto part = [&](unsigned side, float along, float largest, float u, float v) {
    return 9 * (2 * side + (along < 0)) + 3 * third(u, largest) + third(v, largest);
  };
  return x >= y && x >= z ? part(0, n.x, x, n.y, n.z) : y >= z ? part(1, n.y, y, n.z, n.x) : part(2, n.z, z, n.x, n.y);
}

// By part: the bits of those that have directions facing some of it, and of a few others: by intervals of dot products
// of points on the cube.
std::array<std::uint64_t, direction_parts> facing_parts() {
  struct Part {
    std::array<float, 3> low, high;
    float nearest;  // to the centre of the cube
  };
  std::array<Part, direction_parts> parts;
  for (unsigned p = 0; p < direction_parts; ++p) {
    constexpr float edges[] = {-1, -part_edge, part_edge, 1};
    const unsigned side = p / 18, u = p % 9 / 3, v = p % 3;
    Part& part = parts[p];
    part.low[side] = part.high[side] = p / 9 % 2 ? -1.0f : 1.0f;
    for (const auto& [axis, third] : {std::pair((side + 1) % 3, u), std::pair((side + 2) % 3, v)}) {
      part.low[axis] = edges[third];
      part.high[axis] = edges[third + 1];
    }
    part.nearest = std::sqrt(1 + (u == 1 ? 0 : part_edge * part_edge) + (v == 1 ? 0 : part_edge * part_edge));
  }
  std::array<std::uint64_t, direction_parts> bits = {};
  for (unsigned a = 0; a < direction_parts; ++a)
    for (unsigned b = 0; b < direction_parts; ++b) {
      float least = 0;
      for (unsigned k = 0; k < 3; ++k)
        least += std::min({parts[a].low[k] * parts[b].low[k], parts[a].low[k] * parts[b].high[k],
                           parts[a].high[k] * parts[b].low[k], parts[a].high[k] * parts[b].high[k]});
      bits[a] |= std::uint64_t(least <= facing * parts[a].nearest * parts[b].nearest) << b;
    }
  return bits;
}

}  // namespace

// Vertices of a pose in cubic cells. Cells share buckets, and a row of cells along x has consecutive ones.
class ContactFinder::Grid {
 public:
  Grid(std::span<const float> points, std::span<const Vector3> normals, float cell)
      : per_cell_(1 / cell), mask_(std::bit_ceil(2 * normals.size() + 1) - 1), first_(mask_ + 2), parts_(mask_ + 1) {
    if (!normals.empty()) low_ = vector_at(points.data(), 0);
    for (std::size_t v = 0; v < normals.size(); ++v) low_ = lowest(low_, vector_at(points.data(), v));
    std::vector<std::size_t> bucket_of(normals.size());
    for (std::size_t v = 0; v < normals.size(); ++v) {
      const Cell cell_of = cell_at(vector_at(points.data(), v));
      bucket_of[v] = (row(cell_of[1], cell_of[2]) + cell_of[0]) & mask_;
      ++first_[bucket_of[v] + 1];
      parts_[bucket_of[v]] |= std::uint64_t(1) << direction_part(normals[v]);
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    vertices_.resize(normals.size());
    for (std::uint32_t v = 0; v < normals.size(); ++v) vertices_[next[bucket_of[v]]++] = v;
    for (const std::uint32_t v : vertices_) {
      const Vector3 p = vector_at(points.data(), v), n = normals[v];
      const std::array<float, 6> values = {p.x, p.y, p.z, n.x, n.y, n.z};
      for (std::size_t k = 0; k < 6; ++k) places_[k].push_back(values[k]);
    }
  }

  // A triangle, and the box in which vertices near it lie.
  struct Query {
    Vector3 low, high;
    Vector3 normal;
    float least, most;    // dot products of the normal with points near its plane
    float facing;         // largest dot product of the normal with normals that face it
    std::uint64_t parts;  // of directions that may face it
  };

  // Calls `found` with each vertex in the box that is near the plane and faces the triangle, and with others outside
  // the box.
  template <class Found>
  void visit(const Query& query, Found found) const {
    const Cell from = cell_at(query.low), to = cell_at(query.high);
    const double rows = (to[1] - from[1] + 1.0) * (to[2] - from[2] + 1.0);
    if (rows > static_cast<double>(vertices_.size())) return visit(query, 0, vertices_.size(), found);
    for (std::uint64_t z = from[2]; z != to[2] + 1; ++z)
      for (std::uint64_t y = from[1]; y != to[1] + 1; ++y) {
        const std::uint64_t begin = row(y, z) + from[0];
        const std::uint64_t end = begin + std::min(to[0] - from[0], mask_) + 1;
        for (std::uint64_t b = begin; b != end; ++b)
          if (parts_[b & mask_] & query.parts) visit(query, first_[b & mask_], first_[(b & mask_) + 1], found);
      }
  }

 private:
  using Cell = std::array<std::uint64_t, 3>;
  static constexpr float most_cells = 1e9f;  // along an axis

  template <class Found>
  void visit(const Query& query, std::size_t begin, std::size_t end, Found found) const {
    const auto along = [&](std::size_t i, std::size_t first) {
      return places_[first][i] * query.normal.x + places_[first + 1][i] * query.normal.y +
             places_[first + 2][i] * query.normal.z;
    };
    const auto fits = [&](std::size_t i) {
      const float plane = along(i, 0);
      return int(along(i, 3) <= query.facing) & int(plane >= query.least) & int(plane <= query.most);
    };
    int any = 0;  // most often none: a loop without branches
    for (std::size_t i = begin; i < end; ++i) any |= fits(i);
    if (any)
      for (std::size_t i = begin; i < end; ++i)
        if (fits(i)) found(vertices_[i]);
  }

  Cell cell_at(Vector3 p) const {
    const auto along = [&](float x, float low) {
      return static_cast<std::uint64_t>(std::clamp((x - low) * per_cell_, 0.0f, most_cells));
    };
    return {along(p.x, low_.x), along(p.y, low_.y), along(p.z, low_.z)};
  }
  static std::uint64_t row(std::uint64_t y, std::uint64_t z) {
    return ((y * 0x9E3779B97F4A7C15u ^ z) * 0x9E3779B97F4A7C15u) >> 32;
  }

  float per_cell_;
  Vector3 low_;                       // corner of the first cell
  std::uint64_t mask_;                // buckets - 1
  std::vector<std::uint32_t> first_;  // by bucket: of its vertices; buckets + 1 entries
  std::vector<std::uint64_t> parts_;  // by bucket: bits of the parts in which its normals lie
  std::vector<std::uint32_t> vertices_;
  std::array<std::vector<float>, 6> places_;  // of those: x, y, z and the normal's
};

ContactFinder::ContactFinder(const Mesh& rest)
    : distance_(static_cast<float>(visible_gap * rest.diagonal())),
      rest_(rest.points),
      graph_(rest, seams(rest, vertex_normals(rest.triangles(), rest.points))),
      triangles_(rest.triangles()),
      cell_(std::max(cell_edges * mean_edge(graph_), 2 * distance_)),
      facing_parts_(facing_parts()) {
  const auto point = [&](std::size_t corner) { return vector_at(rest_.data(), triangles_[corner]); };
  for (std::size_t t = 0; t < triangles_.size(); t += 3)
    rest_sizes_.push_back(length(cross(point(t + 1) - point(t), point(t + 2) - point(t))));
}

void ContactFinder::search(Pose& pose) const {
  const Grid grid(pose.points, pose.normals, cell_);
  const auto point = [&](std::uint32_t v) { return vector_at(pose.points.data(), v); };
  for (std::uint32_t t = 0; t < triangles_.size() / 3; ++t) {
    const Vector3 a = point(triangles_[3 * t]), b = point(triangles_[3 * t + 1]), c = point(triangles_[3 * t + 2]);
    const Vector3 twice_area = cross(b - a, c - a);
    const float size = length(twice_area), near = distance_ * size;
    if (size == 0 || size < shrunk_share * rest_sizes_[t]) continue;
    const Vector3 around = {distance_, distance_, distance_};
    const float plane = dot(a, twice_area);
    grid.visit({lowest(lowest(a, b), c) - around, highest(highest(a, b), c) + around, twice_area, plane - near,
                plane + near, facing * size, facing_parts_[direction_part(twice_area)]},
               [&](std::uint32_t v) { add_if_nearest(pose, v, t, twice_area * (1 / size)); });
  }
}

void ContactFinder::add_if_nearest(Pose& pose, std::uint32_t v, std::uint32_t triangle, Vector3 normal) const {
  const auto point = [&](std::uint32_t i) { return vector_at(pose.points.data(), i); };
  const std::uint32_t a = triangles_[3 * triangle], b = triangles_[3 * triangle + 1], c = triangles_[3 * triangle + 2];
  const TouchingPair pair = {
      v, {a, b, c}, nearest_weights(point(v), point(a), point(b), point(c)), normalized(normal - pose.normals[v])};
  const Vector3 apart = point(v) - at_weights(pair, point);
  const float squared = dot(apart, apart);
  Nearest& nearest = pose.nearest[v];
  if (squared <= distance_ * distance_ && squared < nearest.squared && !same_sheet(pair, apart) &&
      far_along_surface(pair, pose))
    nearest = {squared, pair};
}

bool ContactFinder::same_sheet(const TouchingPair& pair, Vector3 apart) const {
  const auto at_rest = [&](std::uint32_t i) { return vector_at(rest_.data(), i); };
  const float little = sheet_share * distance_;
  return dot(apart, pair.direction) <= little &&
         std::abs(length(apart) - length(at_rest(pair.vertex) - at_weights(pair, at_rest))) <= little;
}

// Dijkstra's algorithm from the vertex, to its neighbours and as far as places belong together.
bool ContactFinder::far_along_surface(const TouchingPair& pair, Pose& pose) const {
  const float most = surface_distance * distance_;
  std::vector<float>& distance = pose.along_surface;
  using Entry = std::pair<float, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<std::uint32_t> reached = {pair.vertex};
  distance[pair.vertex] = 0;
  queue.emplace(0.0f, pair.vertex);
  while (!queue.empty()) {
    const auto [here, v] = queue.top();
    queue.pop();
    if (here > distance[v]) continue;  // outdated entry
    for (const SurfaceGraph::Edge& edge : graph_.edges(v)) {
      const float there = here + edge.length;
      if ((there > most && v != pair.vertex) || there >= distance[edge.vertex]) continue;
      if (distance[edge.vertex] == INFINITY) reached.push_back(edge.vertex);
      distance[edge.vertex] = there;
      if (there <= most) queue.emplace(there, edge.vertex);
    }
  }
  const bool far =
      std::all_of(pair.corners.begin(), pair.corners.end(), [&](std::uint32_t v) { return distance[v] == INFINITY; });
  for (const std::uint32_t v : reached) distance[v] = INFINITY;
  return far;
}

std::vector<TouchingPair> ContactFinder::touching(std::span<const float> points,
                                                  std::span<const Vector3> normals) const {
  Pose pose{points, normals, std::vector<Nearest>(normals.size()), std::vector<float>(normals.size(), INFINITY)};
  search(pose);
  std::vector<TouchingPair> pairs;
  for (const Nearest& nearest : pose.nearest)
    if (nearest.squared < INFINITY) pairs.push_back(nearest.pair);
  return pairs;
}

void ContactSums::add_frame(std::size_t frame, std::span<const TouchingPair> pairs, std::span<const float> error) {
  const auto error_at = [&](std::uint32_t v) { return vector_at(error.data(), v); };
  const auto square_at = [&](std::uint32_t v) { return double(dot(error_at(v), error_at(v))); };
  const auto vertices = static_cast<std::uint32_t>(error.size() / 3);
  for (std::uint32_t v = 0; v < vertices; ++v) all_squares_ += square_at(v);
  vertices_ += vertices;
  for (const TouchingPair& pair : pairs) {
    touching_squares_ += square_at(pair.vertex);
    const double gap = dot(error_at(pair.vertex) - at_weights(pair, error_at), pair.direction);
    squares_ += gap * gap;
    errors_.open += gap > visible_gap;
    errors_.deep += gap < -visible_gap;
    if (std::abs(gap) <= errors_.max) continue;
    errors_.max = std::abs(gap);
    errors_.worst = gap;
    errors_.worst_vertex = pair.vertex;
    errors_.worst_frame = frame;
  }
  ++errors_.looked_at;
  errors_.frames += !pairs.empty();
  errors_.pairs += pairs.size();
}

void ContactSums::append(const ContactSums& later, std::size_t first_frame) {
  squares_ += later.squares_;
  touching_squares_ += later.touching_squares_;
  all_squares_ += later.all_squares_;
  vertices_ += later.vertices_;
  errors_.looked_at += later.errors_.looked_at;
  errors_.frames += later.errors_.frames;
  errors_.pairs += later.errors_.pairs;
  errors_.open += later.errors_.open;
  errors_.deep += later.errors_.deep;
  if (later.errors_.max <= errors_.max) return;
  errors_.max = later.errors_.max;
  errors_.worst = later.errors_.worst;
  errors_.worst_vertex = later.errors_.worst_vertex;
  errors_.worst_frame = first_frame + later.errors_.worst_frame;
}

ContactErrors ContactSums::figures() const {
  ContactErrors figures = errors_;
  if (figures.pairs > 0) {
    figures.rms = std::sqrt(squares_ / static_cast<double>(figures.pairs));
    figures.vertex_share = static_cast<double>(figures.pairs) / static_cast<double>(vertices_);
  }
  if (all_squares_ > 0) figures.error_share = touching_squares_ / all_squares_;
  return figures;
}

}  // namespace fb::bake
