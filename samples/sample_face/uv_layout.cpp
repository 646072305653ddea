#include "uv_layout.h"

#include <algorithm>
#include <utility>

#include "anatomy.h"

namespace sample_face {
namespace {

// A box of the square, with room between it and the next.
struct Box {
  float left, bottom, right, top;

  Uv at(float u, float v) const { return {mix(left, right, u), mix(bottom, top, v)}; }
  // On a circle that fills the box, by turns from its right side upwards.
  Uv on_circle(float turns, float radius = 1) const {
    const float angle = 2 * kPi * turns;
    return at(0.5f + 0.5f * radius * std::cos(angle), 0.5f + 0.5f * radius * std::sin(angle));
  }
};
constexpr Box kSkin{0.006f, 0.262f, 0.994f, 0.994f};
constexpr Box kEyes[2] = {{0.258f, 0.006f, 0.502f, 0.25f}, {0.006f, 0.006f, 0.25f, 0.25f}};  // left, right
constexpr Box kMouth{0.51f, 0.006f, 0.70f, 0.25f};
constexpr Box kTongue{0.708f, 0.006f, 0.828f, 0.25f};
constexpr Box kTeeth[2] = {{0.836f, 0.006f, 0.91f, 0.25f}, {0.918f, 0.006f, 0.992f, 0.25f}};  // upper, lower

// Small boxes beside the crown for what nobody sees: the backs of eyes and tongue, the ends of teeth.
Box hidden_box(int number) {
  constexpr float kSize = 0.03f, kStep = 0.036f;
  const float left = number % 2 == 0 ? 0.006f : 0.994f - kSize, top = 0.994f - kStep * float(number / 2);
  return {left, top - kSize, left + kSize, top};
}

constexpr auto kAsItIs = [](Vec3) { return 1.0f; };

std::vector<Index> quads_from(Index first, std::size_t count) {
  std::vector<Index> quads(count);
  for (std::size_t i = 0; i < count; ++i) quads[i] = first + Index(i);
  return quads;
}

// The first of a component's quads, which follow one another.
Index first_quad(const FaceMesh& mesh, Span span) {
  Index quad = 0;
  while (mesh.quads[quad][0] < span.first || mesh.quads[quad][0] >= span.first + span.count) ++quad;
  return quad;
}

// A disc that a closed ring is the edge of, which runs counter-clockwise in it.
void lay_out_disc(const FaceMesh& mesh, std::vector<Index> quads, const Ring& edge, Box box, int passes, float turn,
                  FaceUvs& uvs) {
  Chart chart(mesh, std::move(quads));
  for (std::size_t i = 0; i < edge.size(); ++i)
    chart.place(chart.point(edge[i]), box.on_circle(turn + float(i) / float(edge.size())));
  chart.start([&](Vec3) { return box.at(0.5f, 0.5f); });
  chart.relax(passes, 150, kAsItIs);
  chart.add_to(uvs);
}

// ---- The skin

bool is_inside_mouth(const std::vector<bool>& inside, const std::array<Index, 4>& quad) {
  return std::ranges::all_of(quad, [&](Index v) { return inside[v]; });
}

// Along the edge of the skin's chart: up a side, then round to the middle of the upper edge. t from 0 to 1.
Uv on_left_side(float t) {
  constexpr float kStraight = 0.56f, kEnd = 0.55f;  // part of the way, and of the height, that is straight
  if (t < kStraight) return {0, kEnd * t / kStraight};
  const float angle = 0.5f * kPi * (t - kStraight) / (1 - kStraight);
  return {0.5f - 0.5f * std::cos(angle), kEnd + (1 - kEnd) * std::sin(angle)};
}

void place_skin_edge(const FaceMesh& mesh, Chart& chart) {
  std::vector<float> way = {0};
  for (std::size_t i = 1; i < mesh.seam.size(); ++i)
    way.push_back(way.back() + length(mesh.points[mesh.seam[i]] - mesh.points[mesh.seam[i - 1]]));
  for (std::size_t i = 0; i < mesh.seam.size(); ++i) {
    const Uv side = on_left_side(way[i] / way.back());
    chart.place(chart.point(mesh.seam[i]), kSkin.at(1 - side.u, side.v));
    if (i + 1 < mesh.seam.size()) chart.place(chart.point(mesh.seam[i], true), kSkin.at(side.u, side.v));
  }
  const int columns = int(mesh.neck.size());
  for (int column = 1 - columns / 2; column < columns / 2; ++column)
    chart.place(chart.point(mesh.neck[std::size_t((column + columns) % columns)]),
                kSkin.at(0.5f + float(column) / float(columns), 0));
}

// The face has more of the picture than the back of the head and the neck.
float skin_scale(Vec3 p) {
  return mix(1.0f, 1.9f, smoothstep(0.5f, 6.5f, p.z) * smoothstep(-13, -9, p.y) * (1 - smoothstep(4, 8, p.y)));
}

void lay_out_skin(const FaceMesh& mesh, FaceUvs& uvs) {
  std::vector<bool> inside(mesh.points.size(), false);
  for (int ring = kLipBack; ring < kMouthRings; ++ring)
    for (const Index v : mesh.mouth[ring]) inside[v] = true;
  for (const Index v : mesh.throat) inside[v] = true;
  std::vector<Index> skin, mouth;
  for (const Index quad : quads_from(0, first_quad(mesh, mesh.eyes[0])))
    (is_inside_mouth(inside, mesh.quads[quad]) ? mouth : skin).push_back(quad);

  Chart chart(mesh, std::move(skin), mesh.seam);
  place_skin_edge(mesh, chart);
  chart.start([](Vec3 p) { return kSkin.at(0.5f + std::atan2(p.x, p.z) / (2 * kPi), (p.y + 17) / 28); });
  chart.add_hole(mesh.mouth[kLipBack]);
  for (const auto& lids : mesh.lids) chart.add_hole(lids[kLidInner]);
  chart.relax(3, 60, skin_scale);
  chart.add_to(uvs);
  lay_out_disc(mesh, std::move(mouth), mesh.mouth[kLipBack], kMouth, 4, -19.0f / kMouthColumns, uvs);
}

// ---- What is in it

// Distance from the middle of an eye's disc, by the angle from its line of sight: the iris has half of it.
float eye_radius(float degrees) {
  constexpr float kIris = 25.5f, kSeen = 65, kEdge = 148;
  if (degrees < kIris) return 0.55f * degrees / kIris;
  if (degrees < kSeen) return mix(0.55f, 0.88f, (degrees - kIris) / (kSeen - kIris));
  return mix(0.88f, 1.0f, (degrees - kSeen) / (kEdge - kSeen));
}

void lay_out_eye(const FaceMesh& mesh, int eye, FaceUvs& uvs) {
  const std::vector<Ring>& rings = mesh.eye_rings[eye];
  const Index first = first_quad(mesh, mesh.eyes[eye]);
  const std::size_t columns = rings[0].size(), cap = (columns / 4) * (columns / 4);
  const std::size_t front = (rings.size() - 1) * columns + cap;
  Chart chart(mesh, quads_from(first, front));
  for (const Ring& ring : rings)
    for (std::size_t i = 0; i < columns; ++i) {
      const Vec3 d = unit(mesh.points[ring[i]] - eye_centre(eye == 0 ? 1 : -1));
      const float degrees = std::acos(std::clamp(d.z, -1.0f, 1.0f)) * (180 / kPi);
      chart.place(chart.point(ring[i]), kEyes[eye].on_circle(float(i) / float(columns), eye_radius(degrees)));
    }
  chart.start([&](Vec3) { return kEyes[eye].at(0.5f, 0.5f); });
  chart.relax(0, 150, kAsItIs);
  chart.add_to(uvs);
  lay_out_disc(mesh, quads_from(first + Index(front), cap), Ring(rings.back().rbegin(), rings.back().rend()),
               hidden_box(eye), 0, 0, uvs);
}

void lay_out_tongue(const FaceMesh& mesh, FaceUvs& uvs) {
  const std::vector<Ring>& rings = mesh.tongue_rings;
  const Index first = first_quad(mesh, mesh.tongue);
  const std::size_t columns = rings[0].size(), cap = (columns / 4) * (columns / 4);
  const std::size_t front = (rings.size() - 1) * columns + cap;
  Chart chart(mesh, quads_from(first, front));
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (std::size_t i = 0; i < columns; ++i)
      chart.place(chart.point(rings[r][i]),
                  kTongue.on_circle(0.625f + float(i) / float(columns), float(r + 1) / float(rings.size())));
  chart.start([](Vec3) { return kTongue.at(0.5f, 0.5f); });
  chart.relax(0, 150, kAsItIs);
  chart.add_to(uvs);
  lay_out_disc(mesh, quads_from(first + Index(front), cap), Ring(rings.back().rbegin(), rings.back().rend()),
               hidden_box(2), 0, 0, uvs);
}

// A row of teeth unrolled: along it downwards, round it to the left.
void lay_out_teeth(const FaceMesh& mesh, int row, FaceUvs& uvs) {
  const std::vector<Ring>& rings = mesh.teeth_rings[row];
  const std::size_t round = rings[0].size(), width = round + 1, cap = (round / 4) * (round / 4);
  const Index first = first_quad(mesh, row == 0 ? mesh.upper_teeth : mesh.lower_teeth);
  const Index pairs = Index(uvs.pairs.size());
  for (std::size_t i = 0; i < rings.size(); ++i)
    for (std::size_t j = 0; j < width; ++j)
      uvs.pairs.push_back(kTeeth[row].at(1 - float(j) / float(round), float(i) / float(rings.size() - 1)));
  for (std::size_t i = 0; i + 1 < rings.size(); ++i)
    for (std::size_t j = 0; j < round; ++j) {
      const Index corner = pairs + Index(i * width + j);
      uvs.corners[first + i * round + j] = {corner + Index(width), corner + Index(width) + 1, corner + 1, corner};
    }
  const Index ends = first + Index((rings.size() - 1) * round);
  lay_out_disc(mesh, quads_from(ends, cap), Ring(rings.front().rbegin(), rings.front().rend()), hidden_box(4 + 2 * row),
               0, 0, uvs);
  lay_out_disc(mesh, quads_from(ends + Index(cap), cap), rings.back(), hidden_box(5 + 2 * row), 0, 0, uvs);
}

}  // namespace

FaceUvs lay_out(const FaceMesh& mesh) {
  FaceUvs uvs;
  uvs.corners.resize(mesh.quads.size());
  lay_out_skin(mesh, uvs);
  for (int eye = 0; eye < 2; ++eye) lay_out_eye(mesh, eye, uvs);
  for (int row = 0; row < 2; ++row) lay_out_teeth(mesh, row, uvs);
  lay_out_tongue(mesh, uvs);
  // Sixteenths of a pixel of the picture: an archive has them in less than half of the bytes.
  constexpr float kSteps = 8192;
  for (Uv& at : uvs.pairs) at = {std::round(at.u * kSteps) / kSteps, std::round(at.v * kSteps) / kSteps};
  return uvs;
}

}  // namespace sample_face
