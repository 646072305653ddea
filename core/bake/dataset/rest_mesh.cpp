#include "bake/dataset/rest_mesh.h"

#include <tiny_gltf.h>

#include <algorithm>

#include "bake/dataset/dataset_index.h"
#include "bake/dataset/npy.h"
#include "bake/rig/gltf/gltf_mesh.h"
#include "base/checked.h"
#include "base/file.h"
#include "base/file_extension.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

void check_as(const Mesh& mesh, const std::filesystem::path& path) {
  try {
    check(mesh);
  } catch (const Error& error) {
    fail(error.status(), "%s: %s", shown(path).c_str(), error.what());
  }
}

// Rows of `width` numbers as floats.
std::vector<float> read_rows(const std::filesystem::path& path, std::size_t width, const char* need) {
  const NpyFile file(path);
  if (file.shape().size() != 2 || file.shape()[1] != width)
    fail(Status::bad_data, "%s: shape %s where %s is needed", shown(path).c_str(), file.shape_text().c_str(), need);
  std::vector<float> values(file.rows() * width);
  file.read(0, file.rows(), values);
  return values;
}

struct Faces {
  std::vector<std::uint32_t> sizes, corners;
};

// Rows of corners, padded with -1; `what`: vertices or texture coordinates, for messages.
Faces read_faces(const std::filesystem::path& path, const char* what) {
  const NpyFile file(path);
  if (file.shape().size() != 2 || file.shape()[1] < 3)
    fail(Status::bad_data, "%s: shape %s where (faces, corners), at least 3 corners, is needed", shown(path).c_str(),
         file.shape_text().c_str());
  Faces faces;
  const std::vector<std::int32_t> corners = file.read_integers();
  const std::size_t width = file.row_size();
  for (std::size_t face = 0; face < file.rows(); ++face) {
    const auto row = corners.begin() + static_cast<std::ptrdiff_t>(face * width),
               end = row + static_cast<std::ptrdiff_t>(width);
    const auto pad = std::find(row, end, -1);
    if (std::find_if(pad, end, [](std::int32_t corner) { return corner != -1; }) != end)
      fail(Status::bad_data, "%s: face %zu goes on after a -1", shown(path).c_str(), face);
    for (auto corner = row; corner != pad; ++corner) {
      if (*corner < 0) fail(Status::bad_data, "%s: face %zu names %s %d", shown(path).c_str(), face, what, *corner);
      faces.corners.push_back(static_cast<std::uint32_t>(*corner));
    }
    faces.sizes.push_back(static_cast<std::uint32_t>(pad - row));
  }
  return faces;
}

void write_faces(const std::filesystem::path& path, const std::vector<std::uint32_t>& sizes,
                 const std::vector<std::uint32_t>& corners) {
  std::size_t width = 3;
  for (const std::uint32_t size : sizes) width = std::max<std::size_t>(width, size);
  std::vector<std::int32_t> rows(checked_multiply(sizes.size(), width, "faces"), -1);
  std::size_t first = 0;
  for (std::size_t face = 0; face < sizes.size(); ++face) {
    for (std::size_t k = 0; k < sizes[face]; ++k)
      rows[face * width + k] = static_cast<std::int32_t>(corners[first + k]);
    first += sizes[face];
  }
  write_npy(path, {sizes.size(), width}, rows);
}

}  // namespace

Mesh read_mesh(const std::filesystem::path& path) {
  const std::string extension = file_extension(path);
  if (extension != ".obj" && extension != ".glb")
    fail(Status::bad_data, "%s: a rest mesh is read from .obj or .glb", shown(path).c_str());
  const Mesh mesh = extension == ".obj" ? read_obj(path) : read_glb(path);
  check_as(mesh, path);
  return mesh;
}

Mesh read_glb(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, std::uint64_t{1} << 31);
  return with_context(shown(path), [&] {
    const GltfFile file(bytes);
    const auto& meshes = file.model().meshes;
    if (meshes.size() != 1)
      fail(Status::bad_data, "holds %zu meshes; a rest mesh is the only one in its file", meshes.size());
    return read_gltf_surface(file, meshes[0]);
  });
}

Mesh read_npy_mesh(const std::filesystem::path& folder, const MeshArrays& files) {
  const auto inside = [&](const std::string& name) { return dataset_path(folder, name); };
  Mesh mesh;
  mesh.points = read_rows(inside(files.points), 3, "(vertices, 3)");
  Faces faces = read_faces(inside(files.faces), "vertex");
  mesh.polygon_sizes = std::move(faces.sizes);
  mesh.polygon_corners = std::move(faces.corners);
  if (!files.uvs.empty()) {
    mesh.uvs = read_rows(inside(files.uvs), 2, "(texture coordinates, 2)");
    Faces of_uvs = read_faces(inside(files.uv_faces), "texture coordinate");
    if (of_uvs.sizes != mesh.polygon_sizes)
      fail(Status::bad_data, "%s: its faces are not those of %s", shown(folder / files.uv_faces).c_str(),
           shown(files.faces).c_str());
    mesh.uv_corners = std::move(of_uvs.corners);
  }
  check_as(mesh, folder);
  return mesh;
}

void write_npy_mesh(const Mesh& mesh, const std::filesystem::path& folder, const MeshArrays& files) {
  write_npy(folder / files.points, {mesh.surface_vertex_count(), 3}, mesh.surface_points());
  write_faces(folder / files.faces, mesh.polygon_sizes, mesh.polygon_corners);
  if (files.uvs.empty()) return;
  write_npy(folder / files.uvs, {mesh.uvs.size() / 2, 2}, mesh.uvs);
  write_faces(folder / files.uv_faces, mesh.polygon_sizes, mesh.uv_corners);
}

}  // namespace fb::bake
