#include "bake/dataset/rest_mesh.h"

#include <algorithm>

#include "bake/dataset/npy.h"
#include "base/checked.h"
#include "base/status.h"

namespace fb {
namespace {

void check_as(const Mesh& mesh, const std::filesystem::path& path) {
  try {
    check(mesh);
  } catch (const Error& error) {
    fail(error.status(), "%s: %s", path.c_str(), error.what());
  }
}

}  // namespace

Mesh read_mesh(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension != ".obj" && extension != ".glb")
    fail(Status::bad_data, "%s: a rest mesh is read from .obj or .glb", path.c_str());
  const Mesh mesh = extension == ".obj" ? read_obj(path) : read_glb(path);
  check_as(mesh, path);
  return mesh;
}

Mesh read_npy_mesh(const std::filesystem::path& points_path, const std::filesystem::path& faces_path) {
  const NpyFile points(points_path), faces(faces_path);
  if (points.shape().size() != 2 || points.shape()[1] != 3)
    fail(Status::bad_data, "%s: shape %s where (vertices, 3) is needed", points_path.c_str(),
         points.shape_text().c_str());
  if (faces.shape().size() != 2 || faces.shape()[1] < 3)
    fail(Status::bad_data, "%s: shape %s where (faces, corners), at least 3 corners, is needed", faces_path.c_str(),
         faces.shape_text().c_str());
  Mesh mesh;
  mesh.points.resize(points.rows() * 3);
  points.read(0, points.rows(), mesh.points);
  const std::vector<std::int32_t> corners = faces.read_integers();
  const std::size_t width = faces.row_size();
  for (std::size_t face = 0; face < faces.rows(); ++face) {
    const auto row = corners.begin() + static_cast<std::ptrdiff_t>(face * width),
               end = row + static_cast<std::ptrdiff_t>(width);
    const auto pad = std::find(row, end, -1);
    if (std::find_if(pad, end, [](std::int32_t corner) { return corner != -1; }) != end)
      fail(Status::bad_data, "%s: face %zu goes on after a -1", faces_path.c_str(), face);
    for (auto corner = row; corner != pad; ++corner) {
      if (*corner < 0) fail(Status::bad_data, "%s: face %zu names vertex %d", faces_path.c_str(), face, *corner);
      mesh.polygon_corners.push_back(static_cast<std::uint32_t>(*corner));
    }
    mesh.polygon_sizes.push_back(static_cast<std::uint32_t>(pad - row));
  }
  check_as(mesh, faces_path.parent_path());
  return mesh;
}

void write_npy_mesh(const Mesh& mesh, const std::filesystem::path& points, const std::filesystem::path& faces) {
  write_npy(points, {mesh.vertex_count(), 3}, mesh.points);
  std::size_t width = 3;
  for (const std::uint32_t size : mesh.polygon_sizes) width = std::max<std::size_t>(width, size);
  std::vector<std::int32_t> rows(checked_multiply(mesh.polygon_sizes.size(), width, "faces"), -1);
  std::size_t first = 0;
  for (std::size_t face = 0; face < mesh.polygon_sizes.size(); ++face) {
    for (std::size_t k = 0; k < mesh.polygon_sizes[face]; ++k)
      rows[face * width + k] = static_cast<std::int32_t>(mesh.polygon_corners[first + k]);
    first += mesh.polygon_sizes[face];
  }
  write_npy(faces, {mesh.polygon_sizes.size(), width}, rows);
}

}  // namespace fb
