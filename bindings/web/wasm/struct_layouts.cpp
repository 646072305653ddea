// Where the members of the public structs are in this module's memory, for the TypeScript side, which reads them there.
#include <facebaker/facebaker.h>
#include <facebaker/facebaker_character.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>

namespace {

// "u32", "u64", "f32", "text" (a pointer to a string), "pointer"; of an array that of its elements.
template <class Member>
constexpr const char* kind_of() {
  using Element = std::remove_all_extents_t<Member>;
  if (std::is_same_v<Element, const char*>) return "text";
  if (std::is_pointer_v<Element>) return "pointer";
  if (std::is_same_v<Element, float>) return "f32";
  if (std::is_same_v<Element, std::uint64_t>) return "u64";
  static_assert(std::is_pointer_v<Element> || sizeof(Element) == 4 || sizeof(Element) == 8);
  return "u32";
}

class Layouts {
 public:
  void begin(const char* name, std::size_t size) {
    text_ += (text_.empty() ? "{\"" : "},\"") + std::string(name) + "\":{\"\":[" + std::to_string(size) + "]";
  }
  template <class Member>
  void add(const char* name, std::size_t offset) {
    constexpr std::size_t count = std::is_array_v<Member> ? std::extent_v<Member> : 0;  // 0: no array
    text_ += ",\"" + std::string(name) + "\":[" + std::to_string(offset) + ",\"" + kind_of<Member>() + "\"" +
             (count > 0 ? "," + std::to_string(count) : "") + "]";
  }
  std::string text() const { return text_ + "}}"; }

 private:
  std::string text_;
};

#define FB_BEGIN(structure)   \
  {                           \
    using Struct = structure; \
    layouts.begin(#structure, sizeof(Struct));
#define FB_MEMBER(member) layouts.add<decltype(Struct::member)>(#member, offsetof(Struct, member));
#define FB_END }

std::string write_layouts() {
  Layouts layouts;
  // clang-format off
  FB_BEGIN(fb_load_desc)
    FB_MEMBER(max_file_bytes) FB_MEMBER(max_model_bytes) FB_MEMBER(instruction_set) FB_MEMBER(max_name_bytes)
    FB_MEMBER(max_vertices) FB_MEMBER(max_polygons) FB_MEMBER(max_features)
  FB_END
  FB_BEGIN(fb_control)
    FB_MEMBER(name) FB_MEMBER(group) FB_MEMBER(minimum) FB_MEMBER(maximum) FB_MEMBER(rest) FB_MEMBER(mirror)
    FB_MEMBER(arkit) FB_MEMBER(facs) FB_MEMBER(unit)
  FB_END
  FB_BEGIN(fb_row_block) FB_MEMBER(first_row) FB_MEMBER(row_count) FB_MEMBER(column_count)
    FB_MEMBER(digit_column_count)
  FB_END
  FB_BEGIN(fb_batch_desc)
    FB_MEMBER(threads) FB_MEMBER(poses) FB_MEMBER(controls) FB_MEMBER(control_floats) FB_MEMBER(control_stride)
    FB_MEMBER(positions) FB_MEMBER(position_floats) FB_MEMBER(pose_stride) FB_MEMBER(vertex_stride)
    FB_MEMBER(vertex_order) FB_MEMBER(format) FB_MEMBER(normals) FB_MEMBER(normal_numbers)
    FB_MEMBER(normal_pose_stride) FB_MEMBER(normal_vertex_stride) FB_MEMBER(regions) FB_MEMBER(region_count)
    FB_MEMBER(tangents) FB_MEMBER(tangent_numbers) FB_MEMBER(tangent_pose_stride) FB_MEMBER(tangent_vertex_stride)
    FB_MEMBER(meshes) FB_MEMBER(mesh_count) FB_MEMBER(sockets) FB_MEMBER(socket_floats)
    FB_MEMBER(socket_pose_stride) FB_MEMBER(channels) FB_MEMBER(channel_floats) FB_MEMBER(channel_pose_stride)
    FB_MEMBER(expected_errors) FB_MEMBER(expected_error_floats) FB_MEMBER(expected_error_pose_stride)
    FB_MEMBER(outside) FB_MEMBER(displacements) FB_MEMBER(bounds) FB_MEMBER(bounds_floats)
    FB_MEMBER(bounds_pose_stride) FB_MEMBER(lod) FB_MEMBER(level_only)
  FB_END
  FB_BEGIN(fb_material_run) FB_MEMBER(polygon_count) FB_MEMBER(material) FB_END
  FB_BEGIN(fb_mesh)
    FB_MEMBER(run_count) FB_MEMBER(name) FB_MEMBER(runs) FB_MEMBER(vertex_count) FB_MEMBER(polygon_count)
    FB_MEMBER(first_vertex) FB_MEMBER(first_polygon) FB_MEMBER(first_corner) FB_MEMBER(corner_count)
  FB_END
  FB_BEGIN(fb_texture) FB_MEMBER(slot) FB_MEMBER(image) FB_MEMBER(wrap_u) FB_MEMBER(wrap_v) FB_MEMBER(scale) FB_END
  FB_BEGIN(fb_material)
    FB_MEMBER(alpha_mode) FB_MEMBER(name) FB_MEMBER(base_colour) FB_MEMBER(metallic) FB_MEMBER(roughness)
    FB_MEMBER(emissive) FB_MEMBER(alpha_cutoff) FB_MEMBER(double_sided) FB_MEMBER(texture_count) FB_MEMBER(textures)
  FB_END
  FB_BEGIN(fb_image) FB_MEMBER(name) FB_MEMBER(media_type) FB_MEMBER(bytes) FB_MEMBER(byte_count) FB_END
  FB_BEGIN(fb_socket)
    FB_MEMBER(vertex_count) FB_MEMBER(name) FB_MEMBER(vertices) FB_MEMBER(weights) FB_MEMBER(frame)
  FB_END
  FB_BEGIN(fb_channel) FB_MEMBER(name) FB_MEMBER(unit) FB_MEMBER(minimum) FB_MEMBER(maximum) FB_MEMBER(rest) FB_END
  FB_BEGIN(fb_exact_pose) FB_MEMBER(control_count) FB_MEMBER(name) FB_MEMBER(controls) FB_END
  FB_BEGIN(fb_joint) FB_MEMBER(parent) FB_MEMBER(name) FB_MEMBER(rest) FB_MEMBER(inverse_bind) FB_END
  FB_BEGIN(fb_level)
    FB_MEMBER(vertex_count) FB_MEMBER(polygon_count) FB_MEMBER(corner_count) FB_MEMBER(polygon_sizes)
    FB_MEMBER(polygon_corners) FB_MEMBER(uv_corners) FB_MEMBER(meshes) FB_MEMBER(coefficient_count)
  FB_END
      // clang-format on
      return layouts.text();
}

}  // namespace

// {"fb_control": {"": [size], "name": [offset, "text"], "frame": [offset, "f32", 12], ...}, ...}. Static storage.
extern "C" const char* fb_web_layouts() {
  static const std::string text = write_layouts();
  return text.c_str();
}
