#include "bake/rig/gltf/gltf_mesh.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "bake/rig/gltf/texture_placement.h"
#include "base/checked.h"

namespace fb::bake {
namespace {

using Attributes = std::map<std::string, int>;

// A primitive of triangles and the place of its vertices among those of the mesh.
struct TrianglePrimitive {
  const tinygltf::Primitive& primitive;
  std::size_t first, vertices;
  bool shared;  // with a primitive before it
};

int accessor_of(const Attributes& attributes, const std::string& name) {
  const auto found = attributes.find(name);
  return found == attributes.end() ? -1 : found->second;
}

std::vector<TrianglePrimitive> triangle_primitives(const GltfFile& file, const tinygltf::Mesh& mesh,
                                                   LeftOut& left_out) {
  std::vector<TrianglePrimitive> found;
  std::map<std::pair<Attributes, std::vector<Attributes>>, std::size_t> same_vertices;
  std::size_t end = 0;
  for (const tinygltf::Primitive& primitive : mesh.primitives) {
    if (primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode <= TINYGLTF_MODE_LINE_STRIP) {
      left_out.add("points and lines are left out", shown_name(mesh.name));
      continue;
    }
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
      fail(Status::bad_data, "a primitive has the unknown mode %d", primitive.mode);
    const int positions = accessor_of(primitive.attributes, "POSITION");
    if (positions < 0) {
      left_out.add("primitives without positions are left out", shown_name(mesh.name));
      continue;
    }
    const std::size_t vertices = file.count(positions, "positions");
    const auto [at, fresh] = same_vertices.try_emplace({primitive.attributes, primitive.targets}, end);
    found.push_back({primitive, at->second, vertices, !fresh});
    if (fresh) end = checked_add(end, vertices, "vertices");
  }
  return found;
}

// glTF 2.0, section 3.7.2.1: vertices of the triangles that a list, strip or fan of corners makes.
std::vector<std::uint32_t> triangles_of(std::vector<std::uint32_t> corners, int mode) {
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    corners.resize(corners.size() / 3 * 3);
    return corners;
  }
  std::vector<std::uint32_t> triangles;
  for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
    const bool odd = i % 2 == 1;
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
      triangles.insert(triangles.end(), {corners[i], corners[i + (odd ? 2 : 1)], corners[i + (odd ? 1 : 2)]});
    else
      triangles.insert(triangles.end(), {corners[i + 1], corners[i + 2], corners[0]});
  }
  return triangles;
}

std::vector<std::uint32_t> triangles_of(const GltfFile& file, const TrianglePrimitive& from) {
  if (from.primitive.indices >= 0)
    return triangles_of(file.indices(from.primitive.indices, 1, std::nullopt, from.vertices, "triangles"),
                        from.primitive.mode);
  std::vector<std::uint32_t> corners(from.vertices);
  std::iota(corners.begin(), corners.end(), 0u);
  return triangles_of(corners, from.primitive.mode);
}

// How a primitive's textures are placed; as they are where its material does not say one way.
TexturePlacement placement_for(const GltfFile& file, const TrianglePrimitive& from) {
  const std::vector<tinygltf::Material>& materials = file.model().materials;
  const int material = from.primitive.material;
  if (material < 0 || static_cast<std::size_t>(material) >= materials.size()) return {};
  return common_placement(materials[static_cast<std::size_t>(material)]).value_or(TexturePlacement{});
}

// Primitives that share vertices whose materials place textures otherwise have texture coordinates of their own, behind
// those of all vertices.
void read_uvs(const GltfFile& file, const std::vector<TrianglePrimitive>& primitives,
              const std::vector<MaterialRun>& runs, Mesh& mesh) {
  std::map<std::pair<std::size_t, TexturePlacement>, std::size_t> starts;  // of texture coordinates
  std::vector<std::uint32_t> uv_corners = mesh.polygon_corners;
  std::size_t corner = 0;
  for (std::size_t p = 0; p < primitives.size(); ++p) {
    const TrianglePrimitive& from = primitives[p];
    const std::size_t first_corner = corner;
    corner += std::size_t{3} * runs[p].polygons;
    const int accessor = accessor_of(from.primitive.attributes, "TEXCOORD_0");
    if (accessor < 0) continue;
    if (mesh.uvs.empty()) mesh.uvs.resize(2 * mesh.vertex_count());
    const TexturePlacement placement = placement_for(file, from);
    const std::size_t start = from.shared ? mesh.uvs.size() / 2 : from.first;
    const auto [at, fresh] = starts.try_emplace({from.first, placement}, start);
    for (std::size_t c = first_corner; at->second != from.first && c < corner; ++c)
      uv_corners[c] = checked_u32(at->second + uv_corners[c] - from.first, "texture coordinates");
    if (!fresh) continue;
    const std::vector<float> uvs = file.floats(accessor, 2, from.vertices, "texture coordinates");
    mesh.uvs.resize(std::max(mesh.uvs.size(), 2 * at->second + uvs.size()));
    for (std::size_t i = 0; i < uvs.size(); ++i) {
      const std::size_t axis = i % 2;
      const float placed = static_cast<float>(placement.offset[axis] + placement.scale[axis] * double(uvs[i]));
      mesh.uvs[2 * at->second + i] = axis == 0 ? placed : 1 - placed;  // glTF counts v downwards
    }
  }
  if (!mesh.uvs.empty()) mesh.uv_corners = std::move(uv_corners);
}

// Fills `materials` as in GltfMesh.
Mesh read_surface(const GltfFile& file, const std::vector<TrianglePrimitive>& primitives,
                  std::vector<MaterialRun>& materials) {
  Mesh mesh;
  for (const TrianglePrimitive& from : primitives) {
    if (!from.shared) {
      const std::vector<float> points =
          file.floats(from.primitive.attributes.at("POSITION"), 3, std::nullopt, "positions");
      const auto broken = std::ranges::find_if(points, [](float x) { return !std::isfinite(x); });
      if (broken != points.end())
        fail(Status::not_finite, "vertex %zu is not finite",
             from.first + static_cast<std::size_t>(broken - points.begin()) / 3);
      mesh.points.insert(mesh.points.end(), points.begin(), points.end());
    }
    const std::vector<std::uint32_t> corners = triangles_of(file, from);
    for (const std::uint32_t corner : corners)
      mesh.polygon_corners.push_back(checked_u32(from.first + corner, "vertices"));
    mesh.polygon_sizes.insert(mesh.polygon_sizes.end(), corners.size() / 3, 3);
    const int material = from.primitive.material;
    materials.push_back(
        {checked_u32(corners.size() / 3, "triangles"), material < 0 ? no_material : std::uint32_t(material)});
  }
  read_uvs(file, primitives, materials, mesh);
  return mesh;
}

void add_offsets(MorphTarget& target, const std::vector<float>& offsets, std::size_t first, std::size_t number) {
  for (std::size_t i = 0; i < offsets.size(); i += 3) {
    const float *const offset = &offsets[i], *const end = offset + 3;
    if (!std::all_of(offset, end, [](float x) { return std::isfinite(x); }))
      fail(Status::not_finite, "target %zu: vertex %zu is not finite", number, first + i / 3);
    if (std::all_of(offset, end, [](float x) { return x == 0; })) continue;
    target.vertices.push_back(checked_u32(first + i / 3, "vertices"));
    target.offsets.insert(target.offsets.end(), offset, end);
  }
}

std::vector<MorphTarget> read_targets(const GltfFile& file, const std::vector<TrianglePrimitive>& primitives,
                                      std::size_t count) {
  std::vector<MorphTarget> targets(count);
  for (const TrianglePrimitive& from : primitives)
    for (std::size_t t = 0; t < std::min(count, from.primitive.targets.size()); ++t)
      if (const int accessor = accessor_of(from.primitive.targets[t], "POSITION"); accessor >= 0 && !from.shared)
        add_offsets(targets[t], file.floats(accessor, 3, from.vertices, format("moves of target %zu", t).c_str()),
                    from.first, t);
  return targets;
}

VertexJoints read_joints(const GltfFile& file, const std::vector<TrianglePrimitive>& primitives, std::size_t vertices,
                         std::size_t limit) {
  VertexJoints joints;
  for (const TrianglePrimitive& from : primitives) {
    const Attributes& attributes = from.primitive.attributes;
    std::size_t sets = 0;
    while (attributes.contains(format("JOINTS_%zu", sets))) ++sets;
    joints.per_vertex = std::max(joints.per_vertex, 4 * sets);
  }
  if (joints.per_vertex == 0) fail(Status::bad_data, "has a skin, and vertices without joints");
  joints.joints.resize(checked_multiply(vertices, joints.per_vertex, "joints"));
  joints.weights.resize(joints.joints.size());
  for (const TrianglePrimitive& from : primitives)
    for (std::size_t set = 0; !from.shared && 4 * set < joints.per_vertex; ++set) {
      const int of_joints = accessor_of(from.primitive.attributes, format("JOINTS_%zu", set)),
                of_weights = accessor_of(from.primitive.attributes, format("WEIGHTS_%zu", set));
      if (of_joints < 0) break;
      const std::vector<std::uint32_t> indices = file.indices(of_joints, 4, from.vertices, SIZE_MAX, "joints");
      const std::vector<float> weights = file.floats(of_weights, 4, from.vertices, "weights of joints");
      for (std::size_t v = 0; v < from.vertices; ++v)
        for (std::size_t k = 0; k < 4; ++k) {
          const std::size_t to = (from.first + v) * joints.per_vertex + 4 * set + k;
          joints.weights[to] = weights[4 * v + k];
          if (indices[4 * v + k] < limit)
            joints.joints[to] = indices[4 * v + k];
          else if (joints.weights[to] != 0)  // others fill up what is not used
            fail(Status::bad_data, "index %zu of its joints is %u of %zu", 4 * v + k, indices[4 * v + k], limit);
        }
    }
  return joints;
}

}  // namespace

const char* shown_name(const std::string& name) {
  return name.empty() ? "(unnamed)" : name.c_str();
}

std::size_t target_count(const tinygltf::Mesh& mesh) {
  std::size_t count = 0;
  for (const tinygltf::Primitive& primitive : mesh.primitives) count = std::max(count, primitive.targets.size());
  return count;
}

Mesh read_gltf_surface(const GltfFile& file, const tinygltf::Mesh& mesh) {
  LeftOut unread;
  std::vector<MaterialRun> materials;
  return read_surface(file, triangle_primitives(file, mesh, unread), materials);
}

GltfMesh read_gltf_mesh(const GltfFile& file, const tinygltf::Mesh& mesh, std::size_t joints, LeftOut& left_out) {
  const std::vector<TrianglePrimitive> primitives = triangle_primitives(file, mesh, left_out);
  GltfMesh read;
  read.surface = read_surface(file, primitives, read.materials);
  std::erase_if(read.materials, [](const MaterialRun& run) { return run.polygons == 0; });
  read.targets = read_targets(file, primitives, target_count(mesh));
  if (joints > 0) read.joints = read_joints(file, primitives, read.surface.vertex_count(), joints);
  for (const TrianglePrimitive& from : primitives) {
    if (from.primitive.targets.size() < read.targets.size())
      left_out.add("some primitives have fewer morph targets than others of their mesh, and do not move by the rest",
                   shown_name(mesh.name));
    if (joints > 0 && !from.primitive.attributes.contains("JOINTS_0"))
      left_out.add("some primitives of a mesh with a skin have no joints, and follow the first", shown_name(mesh.name));
    if (from.primitive.attributes.contains("COLOR_0"))
      left_out.add("vertex colours are left out", shown_name(mesh.name));
    if (!read.surface.uvs.empty() && !from.primitive.attributes.contains("TEXCOORD_0"))
      left_out.add("some texture coordinates are missing, and 0", shown_name(mesh.name));
    for (const auto& [name, value] : from.primitive.extensions)
      left_out.add("the extension " + name + " of meshes is left out", shown_name(mesh.name));
  }
  return read;
}

}  // namespace fb::bake
