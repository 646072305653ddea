#include "production/production_mesh.h"

#include <array>
#include <cstdlib>

namespace rigs::production {
namespace {

constexpr int columns = 23, middle = columns / 2;
// Degrees round the head of the columns of one side.
constexpr float azimuths[middle + 1] = {0, 8, 16, 24, 32, 41, 50, 60, 70, 80, 92, 105};
constexpr std::array<float, 27> heights = {-15,   -13.8f, -12.6f, -11.4f, -10.3f, -9.3f, -8.4f, -7.6f, -6.6f,
                                           -5.6f, -4.6f,  -3.6f,  -2.8f,  -2.0f,  -1.2f, -0.6f, 0.3f,  1.2f,
                                           2.1f,  3.0f,   3.7f,   4.5f,   5.4f,   6.4f,  7.4f,  8.4f,  9.2f};
constexpr int rows = static_cast<int>(heights.size());

// Half the width and the depth of the head at a height.
float half_width(float y) {
  return 5.2f + 2.3f * smoothstep(-10, -1, y) - 2.0f * smoothstep(3.5f, 10, y);
}
float depth(float y) {
  return 4.6f + 3.9f * smoothstep(-11, -6, y) + 0.8f * smoothstep(-4, 3, y) - 2.4f * smoothstep(3.5f, 10, y);
}

float gauss(float x, float y, float width, float height) {
  return std::exp(-0.5f * (x * x / (width * width) + y * y / (height * height)));
}

// What nose, brows, sockets, lips and chin add to the smooth head.
float relief(float x, float y) {
  float z = 2.1f * gauss(x, y + 2.2f, 0.9f, 0.9f) + 1.2f * gauss(x, y - 0.2f, 0.6f, 1.6f);
  z += 0.5f * gauss(x, y + 5.2f, 1.8f, 0.9f) + 0.8f * gauss(x, y + 8.3f, 1.4f, 0.8f);
  for (const float side : {-1.0f, 1.0f}) {
    z += 0.5f * gauss(x - 2.6f * side, y - 3.2f, 1.6f, 0.6f) - 0.9f * gauss(x - 3 * side, y - 1.2f, 1.3f, 0.9f);
    z += 0.5f * gauss(x - 3.8f * side, y + 1.8f, 1.4f, 1.2f) + 0.6f * gauss(x - 1.1f * side, y + 2.5f, 0.5f, 0.5f);
  }
  return z;
}

Vec grid_point(int column, int row) {
  const float y = heights[static_cast<std::size_t>(row)];
  const int k = column - middle;
  const float angle = radians(k < 0 ? -azimuths[-k] : azimuths[k]);
  const float x = half_width(y) * std::sin(angle), front = std::max(0.0f, std::cos(angle));
  return {x, y, depth(y) * std::cos(angle) + front * relief(x, y)};
}

// A rectangle of cells that rings round the mouth or an eye fill.
struct Hole {
  int column, row, width, height;

  bool has_cell(int i, int j) const { return i >= column && i < column + width && j >= row && j < row + height; }
  bool has_inside(int i, int j) const { return i > column && i < column + width && j > row && j < row + height; }
};
constexpr Hole holes[] = {{middle - 4, 7, 8, 4}, {middle + 1, 15, 4, 4}, {middle - 5, 15, 4, 4}};

void add_quad(FaceMesh& mesh, std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  mesh.corners.insert(mesh.corners.end(), {a, b, c, d});
}

std::int32_t add_point(FaceMesh& mesh, Vec point, Part part) {
  mesh.points.push_back(point);
  mesh.parts.push_back(part);
  return static_cast<std::int32_t>(mesh.points.size()) - 1;
}

using Ring = std::vector<std::int32_t>;

// Rings from the edge of a hole to an ellipse about `centre`; the vertices of the first half of the way stay skin.
void fill_hole(FaceMesh& mesh, Ring edge, int rings, Vec centre, float width, float height, Part upper, Part lower) {
  const Ring outer = edge;
  for (int ring = 1; ring <= rings; ++ring) {
    const float t = std::sqrt(static_cast<float>(ring) / static_cast<float>(rings));
    Ring inner;
    for (const std::int32_t v : outer) {
      const Vec from = mesh.points[static_cast<std::size_t>(v)];
      const float dx = from.x - centre.x, dy = from.y - centre.y, far = std::hypot(dx, dy);
      const float x = std::lerp(from.x, centre.x + width * dx / far, t);
      const float y = std::lerp(from.y, centre.y + height * dy / far, t);
      const Part part = 2 * ring <= rings ? Part::skin : dy >= 0 ? upper : lower;
      inner.push_back(add_point(mesh, skin_at(x, y), part));
    }
    for (std::size_t i = 0; i < edge.size(); ++i) {
      const std::size_t next = (i + 1) % edge.size();
      add_quad(mesh, edge[i], edge[next], inner[next], inner[i]);
    }
    edge = inner;
  }
}

void add_tongue(FaceMesh& mesh) {
  constexpr int sections = 4, around = 6;
  const auto first = static_cast<std::int32_t>(mesh.points.size());
  for (int s = 0; s < sections; ++s)
    for (int k = 0; k < around; ++k) {
      const float angle = radians(60.0f * static_cast<float>(k)), taper = 1 - 0.18f * static_cast<float>(s);
      add_point(
          mesh,
          {1.3f * taper * std::cos(angle), -5.6f + 0.4f * taper * std::sin(angle), 3.2f + 1.3f * static_cast<float>(s)},
          Part::tongue);
    }
  for (int s = 0; s + 1 < sections; ++s)
    for (int k = 0; k < around; ++k) {
      const std::int32_t a = first + s * around + k, b = first + s * around + (k + 1) % around;
      add_quad(mesh, a, b, b + around, a + around);
    }
}

}  // namespace

Vec skin_at(float x, float y) {
  const float s = std::clamp(x / half_width(y), -1.0f, 1.0f), front = std::sqrt(1 - s * s);
  return {x, y, depth(y) * front + front * relief(x, y)};
}

FaceMesh make_face_mesh() {
  FaceMesh mesh;
  std::array<std::array<std::int32_t, columns>, rows> grid{};
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      bool inside = false;
      for (const Hole& hole : holes) inside = inside || hole.has_inside(i, j);
      if (!inside) grid[j][i] = add_point(mesh, grid_point(i, j), Part::skin);
    }
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i + 1 < columns; ++i) {
      bool inside = false;
      for (const Hole& hole : holes) inside = inside || hole.has_cell(i, j);
      if (!inside) add_quad(mesh, grid[j][i], grid[j][i + 1], grid[j + 1][i + 1], grid[j + 1][i]);
    }
  for (const Hole& h : holes) {
    Ring edge;
    for (int i = 0; i < h.width; ++i) edge.push_back(grid[h.row][h.column + i]);
    for (int j = 0; j < h.height; ++j) edge.push_back(grid[h.row + j][h.column + h.width]);
    for (int i = h.width; i > 0; --i) edge.push_back(grid[h.row + h.height][h.column + i]);
    for (int j = h.height; j > 0; --j) edge.push_back(grid[h.row + j][h.column]);
    const int side = h.column > middle ? 1 : -1;
    if (h.width == 8)
      fill_hole(mesh, edge, 5, mouth_centre, mouth_half_width, 0.06f, Part::upper_lip, Part::lower_lip);
    else
      fill_hole(mesh, edge, 4, eye_centre(side), 1.5f, 0.6f, Part::upper_lid, Part::lower_lid);
  }
  add_tongue(mesh);
  return mesh;
}

}  // namespace rigs::production
