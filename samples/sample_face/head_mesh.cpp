// The skin: a grid of rings round the head, with rectangular holes where loops round the mouth, eyes, ears and nostrils
// take over. Every vertex starts where a ray meets the head's solid; relaxing along the surface evens the spacing.
#include "anatomy.h"
#include "face_mesh.h"
#include "head_shape.h"

namespace sample_face {
namespace {

constexpr int kColumns = 60;  // column 0 is the middle of the face, columns grow towards +x

// One ring of the grid: rays leave the head's axis at height y and climb by `front`, `side`, `back` per centimetre.
struct Row {
  float y, front, side, back;
};

constexpr Row kRows[] = {
    {-17.0f, 0, 0, 0},
    {-16.0f, 0, 0, 0},
    {-15.0f, 0, 0, 0.02f},
    {-14.1f, 0.02f, 0, 0.05f},
    {-13.2f, -0.02f, 0, 0.1f},
    {-12.2f, -0.15f, 0, 0.12f},
    {-11.3f, -0.2f, 0, 0.12f},
    {-10.6f, -0.2f, 0, 0.12f},
    {-10.0f, -0.18f, 0, 0.12f},
    {-9.75f, -0.13f, 0, 0.12f},
    {-9.5f, -0.07f, 0, 0.12f},
    {-9.2f, -0.03f, 0, 0.1f},
    {-8.8f, 0, 0, 0.08f},  // bottom of the mouth's hole
    {-8.2f, 0, 0, 0.06f},
    {-7.6f, 0, 0, 0.04f},
    {-7.0f, 0, 0, 0.02f},
    {-6.4f, 0, 0, 0},
    {-5.8f, 0, 0, 0},
    {-5.3f, 0, 0, 0},   // top of the mouth's hole
    {-4.95f, 0, 0, 0},  // bottom of the nostrils
    {-4.6f, 0, 0, 0},
    {-4.2f, 0, 0, 0},  // top of the nostrils
    {-3.9f, 0, 0, 0},
    {-3.5f, 0, 0, 0},
    {-3.1f, 0, 0, 0},
    {-2.75f, 0, 0, 0},
    {-2.4f, 0, 0, 0},  // bottom of the eyes' holes
    {-1.8f, 0, 0, 0},
    {-1.2f, 0, 0, 0},
    {-0.6f, 0, 0, 0},
    {0.0f, 0, 0, 0},
    {0.65f, 0, 0, 0},
    {1.3f, 0, 0, 0},
    {1.95f, 0, 0, 0},
    {2.6f, 0, 0, 0},  // top of the eyes' holes
    {3.2f, 0, 0, 0},
    {3.8f, 0, 0, 0},
    {4.2f, 0.03f, 0.03f, 0.03f},
    {4.4f, 0.1f, 0.1f, 0.1f},
    {4.5f, 0.18f, 0.18f, 0.18f},
    {4.6f, 0.27f, 0.27f, 0.27f},
    {4.6f, 0.38f, 0.38f, 0.38f},
    {4.6f, 0.51f, 0.51f, 0.51f},
    {4.6f, 0.67f, 0.67f, 0.67f},
    {4.6f, 0.87f, 0.87f, 0.87f},
};
constexpr int kRowCount = int(std::size(kRows));

// A hole in the grid: cells [column, column + a) x [row, row + b).
struct Hole {
  int column, row, a, b;
};
constexpr Hole kMouthHole{-8, 12, 16, 6};
constexpr Hole kEyeHole{5, 26, 8, 8};
constexpr Hole kEarHole{18, 22, 3, 10};
constexpr Hole kNostrilHole{1, 19, 2, 2};

constexpr Hole mirrored(Hole h) {
  return {-h.column - h.a, h.row, h.a, h.b};
}
constexpr Hole kHoles[] = {kMouthHole,         kEyeHole,     mirrored(kEyeHole),    kEarHole,
                           mirrored(kEarHole), kNostrilHole, mirrored(kNostrilHole)};

int wrap(int column) {
  return (column % kColumns + kColumns) % kColumns;
}

// Angle round the head of a column: closest together on the nose, wide behind the temples.
float face_angle(int column) {
  constexpr float kNose = 2.6f, kFace = 4.0f, kBack = (180 - 6 * kNose - 9 * kFace) / 15;  // degrees a column
  const int k = column <= kColumns / 2 ? column : kColumns - column;
  const float degrees =
      kNose * float(std::min(k, 6)) + kFace * float(std::clamp(k - 6, 0, 9)) + kBack * float(std::max(k - 15, 0));
  return radians(column <= kColumns / 2 ? degrees : -degrees);
}

Vec3 grid_point(int row, int column) {
  const Row& r = kRows[row];
  // The neck's columns are even; they become the face's towards the chin.
  const float even = 2 * kPi / kColumns * float(column <= kColumns / 2 ? column : column - kColumns);
  const float angle = mix(even, face_angle(column), smoothstep(0, 10, float(row)));
  const float s = std::sin(angle), c = std::cos(angle);
  const float slope = r.side * s * s + (c > 0 ? r.front : r.back) * c * c;
  const Vec3 direction = unit({s, slope, c});
  return hit_head(Vec3{0, r.y, 0} + direction * 20, direction * -1);
}

bool inside_hole(int column, int row) {
  for (const Hole& h : kHoles) {
    const int i = wrap(column - h.column), j = row - h.row;
    if (i > 0 && i < h.a && j > 0 && j < h.b) return true;
  }
  return false;
}

bool hole_cell(int column, int row) {
  for (const Hole& h : kHoles)
    if (wrap(column - h.column) < h.a && row >= h.row && row < h.row + h.b) return true;
  return false;
}

using Grid = std::vector<std::array<Index, kColumns>>;

// The edge of a hole, counter-clockwise from its lower left corner.
Ring edge_of(const Grid& grid, Hole h) {
  Ring ring;
  for (int i = 0; i < h.a; ++i) ring.push_back(grid[h.row][wrap(h.column + i)]);
  for (int j = 0; j < h.b; ++j) ring.push_back(grid[h.row + j][wrap(h.column + h.a)]);
  for (int i = h.a; i > 0; --i) ring.push_back(grid[h.row + h.b][wrap(h.column + i)]);
  for (int j = h.b; j > 0; --j) ring.push_back(grid[h.row + j][wrap(h.column)]);
  return ring;
}

// Moves the free vertices towards the middle of their neighbours and back onto the head, a few times over.
void relax(FaceMesh& mesh, const std::vector<bool>& free) {
  std::vector<std::vector<Index>> neighbours(mesh.points.size());
  for (const auto& q : mesh.quads)
    for (int i = 0; i < 4; ++i) {
      neighbours[q[i]].push_back(q[(i + 1) % 4]);
      neighbours[q[(i + 1) % 4]].push_back(q[i]);
    }
  constexpr int kSteps = 40;
  for (int step = 0; step < kSteps; ++step) {
    std::vector<Vec3> next = mesh.points;
    for (std::size_t v = 0; v < next.size(); ++v) {
      if (!free[v]) continue;
      Vec3 sum;
      for (const Index n : neighbours[v]) sum += mesh.points[n];
      const Vec3 p = mix(mesh.points[v], sum * (1.0f / float(neighbours[v].size())), 0.6f);
      next[v] = p - head_normal(p) * head_distance(p);
    }
    mesh.points.swap(next);
  }
}

}  // namespace

void add_head(FaceMesh& mesh) {
  Grid grid(kRowCount);
  for (int row = 0; row < kRowCount; ++row)
    for (int column = 0; column < kColumns; ++column)
      if (!inside_hole(column, row)) grid[row][column] = mesh.add(grid_point(row, column));
  for (int row = 0; row + 1 < kRowCount; ++row)
    for (int column = 0; column < kColumns; ++column)
      if (!hole_cell(column, row))
        mesh.quads.push_back(
            {grid[row][column], grid[row][wrap(column + 1)], grid[row + 1][wrap(column + 1)], grid[row + 1][column]});
  Ring crown;
  for (int i = 0; i < kColumns; ++i) crown.push_back(grid[kRowCount - 1][wrap(i - 8)]);
  constexpr int kAcross = 16, kAlong = 14;  // of the crown, its last row at the back
  const Ring cap = mesh.cap(crown, kAcross, kAlong);
  mesh.neck.assign(grid[0].begin(), grid[0].end());
  for (int row = 0; row < kRowCount; ++row) mesh.seam.push_back(grid[row][kColumns / 2]);
  for (int j = kAlong - 1; j >= kAlong / 2; --j) mesh.seam.push_back(cap[j * (kAcross + 1) + kAcross / 2]);

  std::vector<bool> free(mesh.points.size(), true);
  for (int column = 0; column < kColumns; ++column) free[grid[0][column]] = false;
  add_mouth_loops(mesh, edge_of(grid, kMouthHole));
  for (int eye = 0; eye < 2; ++eye) add_lid_loops(mesh, edge_of(grid, eye == 0 ? kEyeHole : mirrored(kEyeHole)), eye);
  free.resize(mesh.points.size(), false);
  for (int ring = 1; ring < kLipBorder; ++ring)
    for (int i = 0; i < kMouthColumns; ++i)
      free[mesh.mouth[ring][i]] = ring + 1 < kLipBorder || mouth_column(i).side != 0;  // not drawn in past a corner
  for (const auto& lids : mesh.lids)
    for (int ring = 1; ring < kLidCrease; ++ring)
      for (const Index v : lids[ring]) free[v] = true;
  for (int side = 1; side >= -1; side -= 2) {
    const Hole ear = side > 0 ? kEarHole : mirrored(kEarHole),
               nostril = side > 0 ? kNostrilHole : mirrored(kNostrilHole);
    const Ring ear_edge = edge_of(grid, ear), nostril_edge = edge_of(grid, nostril);
    add_ear_loops(mesh, ear_edge, ear.a, ear.b, side);
    add_nostril_loops(mesh, nostril_edge, nostril.a, nostril.b, side);
    for (const Ring* ring : {&ear_edge, &nostril_edge})
      for (const Index v : *ring) free[v] = false;
  }
  free.resize(mesh.points.size(), false);
  relax(mesh, free);
}

}  // namespace sample_face
