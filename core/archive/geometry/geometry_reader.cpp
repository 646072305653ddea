#include "archive/geometry/geometry_reader.h"

#include <bit>
#include <cmath>

#include "archive/container/container_layout.h"
#include "archive/geometry/draco_reader.h"

namespace fb::archive {
namespace {

// The vertex of each point.
std::pmr::vector<std::uint32_t> read_vertices_of_points(ByteReader& in, std::uint32_t points, std::uint32_t vertices) {
  auto vertex_of = in.temporary_planes(points, "vertices of points");
  std::uint32_t vertex = 0;
  for (std::uint32_t& number : vertex_of) {
    number = vertex += from_zigzag(number);
    if (vertex >= vertices) in.corrupt("a point is of a vertex that does not exist");
  }
  return vertex_of;
}

// A coordinate from the bits of an integer or, with grid step 0, of a float.
float coordinate(std::uint32_t bits, float grid_step) {
  return grid_step == 0 ? std::bit_cast<float>(bits) : static_cast<float>(static_cast<std::int32_t>(bits)) * grid_step;
}

}  // namespace

RestPoints read_geometry(ByteReader& in, std::uint32_t vertices) {
  const auto points = in.number<std::uint32_t>("the number of points");
  const auto triangles = in.number<std::uint32_t>("the number of triangles");
  const auto grid_step = in.number<float>("the grid step");
  int exponent = 0;
  if (grid_step != 0 && !(std::isfinite(grid_step) && grid_step > 0 && std::frexp(grid_step, &exponent) == 0.5f))
    in.corrupt("the grid step is no power of two");
  if (points < vertices) in.corrupt("there are fewer points than vertices");
  const auto vertex_of = read_vertices_of_points(in, points, vertices);
  const DracoMesh mesh = read_draco(in, points, triangles, grid_step != 0);
  RestPoints out;
  in.budget().resize(out.points, std::uint64_t(3) * vertices, "rest points");
  std::pmr::vector<bool> present(vertices, false, &in.budget());
  for (std::size_t p = 0; p < points; ++p)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float x = coordinate(mesh.positions[3 * p + axis], grid_step);
      float& to = out.points[std::size_t(3) * vertex_of[p] + axis];
      if (present[vertex_of[p]] && std::bit_cast<std::uint32_t>(to) != std::bit_cast<std::uint32_t>(x))
        in.corrupt("points of one vertex have different positions");
      to = x;
      if (axis == 2) present[vertex_of[p]] = true;
    }
  for (const bool is_present : present)
    if (!is_present) in.corrupt("a vertex has no point");
  in.budget().reserve(out.triangles, mesh.triangles.size(), "rest triangles");
  for (const std::uint32_t point : mesh.triangles) out.triangles.push_back(vertex_of[point]);
  return out;
}

}  // namespace fb::archive
