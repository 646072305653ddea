#include "bake/rig/rig_description.h"

#include <algorithm>
#include <cstddef>

#include "bake/rig/source_rules.h"

namespace fb::bake {
namespace {

// Size of an fb_rig that ends with texture coordinates, with what the rig prefers, and with its version.
constexpr std::size_t rig_with_uvs = offsetof(fb_rig, preferred_block),
                      rig_with_block = rig_with_uvs + sizeof(fb_rig::preferred_block),
                      rig_with_version = offsetof(fb_rig, version) + sizeof(fb_rig::version);

// An element of an array whose elements may be longer than this header's.
template <class T>
const T& element(const T* array, std::uint32_t stride, std::size_t index) {
  return *reinterpret_cast<const T*>(reinterpret_cast<const std::byte*>(array) + index * stride);
}

// Copies and checks the parts of an fb_rig; messages begin with `label`.
struct Reader {
  std::string label = "rig";  // in messages; with the name of the rig once that has been read

  const char* text(const char* value, const char* field) const {
    if (!value) fail(Status::rig, "%s: %s is null", label.c_str(), field);
    if (!*value) fail(Status::rig, "%s: %s is empty", label.c_str(), field);
    return value;
  }

  template <class T>
  const T* array(const T* pointer, std::uint32_t count, const char* field, const char* count_field) const {
    if (count == 0) fail(Status::rig, "%s: %s is zero", label.c_str(), count_field);
    if (!pointer) fail(Status::rig, "%s: %s is null", label.c_str(), field);
    return pointer;
  }

  template <class T>
  void check_stride(std::uint32_t stride, const char* field, const char* type) const {
    if (stride < sizeof(T))
      fail(Status::rig, "%s: %s is %u, less than the %zu bytes of an %s", label.c_str(), field, stride, sizeof(T),
           type);
    if (stride % alignof(T) != 0)
      fail(Status::rig, "%s: %s is %u, not a multiple of %zu bytes", label.c_str(), field, stride, alignof(T));
  }

  // Whatever check() finds is an error of the rig.
  template <class Check>
  void check_rules(const Check& check) const {
    try {
      check();
    } catch (const Error& error) {
      fail(Status::rig, "%s: %s", label.c_str(), error.what());
    }
  }

  RigSchema schema(const fb_rig& rig) const {
    RigSchema schema;
    schema.name = rig.name;
    schema.units = text(rig.units, "units");
    schema.up_axis = text(rig.up_axis, "up_axis");
    if (schema.up_axis != "y" && schema.up_axis != "z")
      fail(Status::rig, "%s: up_axis is \"%s\", not \"y\" or \"z\"", label.c_str(), rig.up_axis);
    const fb_rig_control* controls = array(rig.controls, rig.control_count, "controls", "control_count");
    check_stride<fb_rig_control>(rig.control_stride, "control_stride", "fb_rig_control");
    for (std::uint32_t i = 0; i < rig.control_count; ++i) {
      const fb_rig_control& c = element(controls, rig.control_stride, i);
      schema.controls.push_back({text(c.name, format("the name of control %u", i).c_str()), c.minimum, c.maximum,
                                 c.rest, c.group ? c.group : ""});
    }
    return schema;
  }

  Mesh mesh(const fb_rig& rig) const {
    const float* points = array(rig.rest_positions, rig.vertex_count, "rest_positions", "vertex_count");
    Mesh mesh;
    mesh.points.assign(points, points + std::size_t{3} * rig.vertex_count);
    if (rig.polygon_count == 0) return mesh;
    const std::uint32_t* sizes = array(rig.polygon_sizes, rig.polygon_count, "polygon_sizes", "polygon_count");
    const std::uint32_t* corners = array(rig.polygon_corners, rig.polygon_count, "polygon_corners", "polygon_count");
    // Sizes are checked before the corners they count are read.
    std::size_t corner_count = 0;
    for (std::uint32_t p = 0; p < rig.polygon_count; ++p) {
      if (sizes[p] < 3 || sizes[p] > rig.vertex_count)
        fail(Status::rig, "%s: polygon %u has %u corners in a mesh of %u vertices", label.c_str(), p, sizes[p],
             rig.vertex_count);
      corner_count += sizes[p];
    }
    mesh.polygon_sizes.assign(sizes, sizes + rig.polygon_count);
    mesh.polygon_corners.assign(corners, corners + corner_count);
    if (rig.struct_size >= rig_with_uvs && rig.uv_count > 0) {
      const float* uvs = array(rig.uvs, rig.uv_count, "uvs", "uv_count");
      const std::uint32_t* of_corners = array(rig.uv_corners, rig.uv_count, "uv_corners", "uv_count");
      mesh.uvs.assign(uvs, uvs + std::size_t{2} * rig.uv_count);
      mesh.uv_corners.assign(of_corners, of_corners + corner_count);
    }
    return mesh;
  }

  Clip clip(const fb_rig_clip& from, std::uint32_t index, const RigSchema& schema) const {
    Clip clip;
    clip.name = text(from.name, format("the name of clip %u", index).c_str());
    const char* name = from.name;
    if (from.kind < FB_CLIP_SHOT || from.kind > FB_CLIP_DENSE)
      fail(Status::rig, "%s: clip \"%s\" is of unknown kind %d", label.c_str(), name, from.kind);
    if (from.split < FB_SPLIT_TRAIN || from.split > FB_SPLIT_TEST)
      fail(Status::rig, "%s: clip \"%s\" belongs to unknown split %d", label.c_str(), name, from.split);
    if (!from.controls) fail(Status::rig, "%s: the controls of clip \"%s\" are null", label.c_str(), name);
    clip.kind = static_cast<ClipKind>(from.kind);
    clip.split = static_cast<Split>(from.split);
    clip.fps = from.fps;
    clip.frames = from.frames;
    clip.controls.assign(from.controls, from.controls + clip.frames * schema.control_count());
    with_context(label, [&] { check_values(clip, schema); });
    return clip;
  }
};

}  // namespace

RigDescription describe(const fb_rig& rig) {
  Reader reader;
  if (rig.abi != FB_RIG_ABI)
    fail(Status::unsupported, "rig: made for rig ABI %u, this library has rig ABI %u: compile it against its header",
         rig.abi, unsigned{FB_RIG_ABI});
  if (rig.struct_size < smallest_rig)
    fail(Status::rig, "rig: struct_size is %u, less than the %zu bytes of an fb_rig", rig.struct_size, smallest_rig);
  reader.label = format("rig \"%s\"", reader.text(rig.name, "name"));
  if (!rig.evaluate) fail(Status::rig, "%s: evaluate is null", reader.label.c_str());
  RigDescription description;
  description.schema = reader.schema(rig);
  description.rest = reader.mesh(rig);
  reader.check_rules([&] { check_source(description.schema, description.rest); });
  if (rig.clip_count > 0) {
    if (!rig.clips) fail(Status::rig, "%s: clips is null", reader.label.c_str());
    reader.check_stride<fb_rig_clip>(rig.clip_stride, "clip_stride", "fb_rig_clip");
  }
  for (std::uint32_t i = 0; i < rig.clip_count; ++i)
    description.clips.push_back(reader.clip(element(rig.clips, rig.clip_stride, i), i, description.schema));
  reader.check_rules([&] { check_clips(description.clips); });
  if (rig.struct_size >= rig_with_block)
    description.preferred_block = std::min<std::size_t>(rig.preferred_block, most_preferred_poses);
  if (rig.struct_size >= rig_with_version && rig.version) description.version = rig.version;
  return description;
}

}  // namespace fb::bake
