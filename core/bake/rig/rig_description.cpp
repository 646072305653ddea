#include "bake/rig/rig_description.h"

#include <algorithm>
#include <cstddef>

#include "bake/rig/about.h"
#include "bake/rig/carried_numbers.h"
#include "bake/rig/driven_pose.h"
#include "bake/rig/source_rules.h"
#include "base/hash.h"

namespace fb::bake {
namespace {

// Size of an fb_rig that ends with texture coordinates, with what the rig prefers, with its version, with what a
// character has, with what is said about it, with channels, with joints, and with which of these controls move.
constexpr std::size_t rig_with_uvs = offsetof(fb_rig, preferred_block),
                      rig_with_block = rig_with_uvs + sizeof(fb_rig::preferred_block),
                      rig_with_version = offsetof(fb_rig, version) + sizeof(fb_rig::version),
                      rig_with_character = offsetof(fb_rig, sockets) + sizeof(fb_rig::sockets),
                      rig_with_about = offsetof(fb_rig, about) + sizeof(fb_rig::about),
                      rig_with_channels = offsetof(fb_rig, evaluate_all) + sizeof(fb_rig::evaluate_all),
                      rig_with_joints = offsetof(fb_rig, evaluate_skinned) + sizeof(fb_rig::evaluate_skinned),
                      rig_with_numbers = offsetof(fb_rig, joint_numbers) + sizeof(fb_rig::joint_numbers);

static_assert(FB_MOST_INFLUENCES == most_influences);

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

  void read_labels(const fb_rig& rig, RigSchema& schema) const {
    if (!rig.labels) return;
    check_stride<fb_rig_labels>(rig.label_stride, "label_stride", "fb_rig_labels");
    const auto known = [](const char* text) { return text ? text : ""; };
    for (std::uint32_t i = 0; i < rig.control_count; ++i) {
      const fb_rig_labels& from = element(rig.labels, rig.label_stride, i);
      schema.controls[i].labels = {known(from.arkit), known(from.facs), known(from.unit), known(from.mirror)};
    }
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

  std::vector<MeshPart> parts(const fb_rig& rig) const {
    std::vector<MeshPart> parts;
    if (rig.mesh_count == 0) return parts;
    const fb_mesh* meshes = array(rig.meshes, rig.mesh_count, "meshes", "mesh_count");
    check_stride<fb_mesh>(rig.mesh_stride, "mesh_stride", "fb_mesh");
    for (std::uint32_t m = 0; m < rig.mesh_count; ++m) {
      const fb_mesh& from = element(meshes, rig.mesh_stride, m);
      MeshPart& part = parts.emplace_back();
      part.name = text(from.name, format("the name of mesh %u", m).c_str());
      part.vertices = from.vertex_count;
      part.polygons = from.polygon_count;
      if (from.run_count > 0 && !from.runs)
        fail(Status::rig, "%s: the runs of mesh \"%s\" are null", label.c_str(), from.name);
      for (std::uint32_t r = 0; r < from.run_count; ++r)
        part.materials.push_back({from.runs[r].polygon_count, from.runs[r].material});
      if (from.run_count == 0 && part.polygons > 0) part.materials = {{part.polygons, no_material}};
    }
    return parts;
  }

  Material material(const fb_material& from, std::uint32_t index) const {
    const auto known = [&](std::uint32_t value, std::uint32_t last, const char* what) {
      if (value > last) fail(Status::rig, "%s: material %u has unknown %s %u", label.c_str(), index, what, value);
      return static_cast<std::uint8_t>(value);
    };
    Material material;
    if (from.name) material.name = from.name;
    std::copy_n(from.base_colour, 4, material.base_colour.begin());
    material.metallic = from.metallic;
    material.roughness = from.roughness;
    std::copy_n(from.emissive, 3, material.emissive.begin());
    material.alpha_mode = static_cast<AlphaMode>(known(from.alpha_mode, FB_ALPHA_BLEND, "alpha_mode"));
    material.alpha_cutoff = from.alpha_cutoff;
    material.double_sided = from.double_sided != 0;
    if (from.texture_count > 0 && !from.textures)
      fail(Status::rig, "%s: the textures of material %u are null", label.c_str(), index);
    for (std::uint32_t t = 0; t < from.texture_count; ++t) {
      const fb_texture& texture = from.textures[t];
      material.textures.push_back({static_cast<TextureSlot>(known(texture.slot, FB_TEXTURE_EMISSIVE, "texture slot")),
                                   texture.image, static_cast<Wrap>(known(texture.wrap_u, FB_WRAP_MIRROR, "wrap")),
                                   static_cast<Wrap>(known(texture.wrap_v, FB_WRAP_MIRROR, "wrap")), texture.scale});
    }
    return material;
  }

  Image image(const fb_image& from, std::uint32_t index) const {
    Image image;
    if (from.name) image.name = from.name;
    image.media_type = text(from.media_type, format("the media type of image %u", index).c_str());
    if (!from.bytes || from.byte_count == 0) fail(Status::rig, "%s: image %u has no bytes", label.c_str(), index);
    if (from.byte_count > UINT32_MAX) fail(Status::rig, "%s: image %u has 4 GiB or more", label.c_str(), index);
    const auto* bytes = static_cast<const std::byte*>(from.bytes);
    image.bytes.assign(bytes, bytes + from.byte_count);
    return image;
  }

  Socket socket(const fb_socket& from, std::uint32_t index, const Mesh& rest) const {
    Socket socket;
    socket.name = text(from.name, format("the name of socket %u", index).c_str());
    const std::uint32_t* vertices = array(from.vertices, from.vertex_count, "vertices of a socket", "vertex_count");
    socket.vertices.assign(vertices, vertices + from.vertex_count);
    if (from.weights)
      socket.weights.assign(from.weights, from.weights + from.vertex_count);
    else
      socket.weights.assign(from.vertex_count, 1.0f);
    std::copy_n(from.frame, FB_FRAME_FLOATS, socket.frame.begin());
    set_default_frame(socket, rest.points);
    return socket;
  }

  // Fills the character's materials, images and sockets.
  void read_character(const fb_rig& rig, const Mesh& rest, Character& character) const {
    if (rig.material_count > 0) {
      const fb_material* materials = array(rig.materials, rig.material_count, "materials", "material_count");
      check_stride<fb_material>(rig.material_stride, "material_stride", "fb_material");
      for (std::uint32_t m = 0; m < rig.material_count; ++m)
        character.materials.push_back(material(element(materials, rig.material_stride, m), m));
    }
    if (rig.image_count > 0) {
      const fb_image* images = array(rig.images, rig.image_count, "images", "image_count");
      check_stride<fb_image>(rig.image_stride, "image_stride", "fb_image");
      for (std::uint32_t i = 0; i < rig.image_count; ++i)
        character.images.push_back(image(element(images, rig.image_stride, i), i));
    }
    if (rig.socket_count > 0) {
      const fb_socket* sockets = array(rig.sockets, rig.socket_count, "sockets", "socket_count");
      check_stride<fb_socket>(rig.socket_stride, "socket_stride", "fb_socket");
      for (std::uint32_t s = 0; s < rig.socket_count; ++s)
        character.sockets.push_back(socket(element(sockets, rig.socket_stride, s), s, rest));
    }
  }

  // Fills joints and skin.
  void read_joints(const fb_rig& rig, Character& character) const {
    if (rig.joint_count == 0) {
      if (rig.skin_influences > 0) fail(Status::rig, "%s: a skin without joints", label.c_str());
      return;
    }
    const fb_joint* joints = array(rig.joints, rig.joint_count, "joints", "joint_count");
    check_stride<fb_joint>(rig.joint_stride, "joint_stride", "fb_joint");
    for (std::uint32_t j = 0; j < rig.joint_count; ++j) {
      const fb_joint& from = element(joints, rig.joint_stride, j);
      Joint& joint = character.joints.emplace_back();
      joint.name = text(from.name, format("the name of joint %u", j).c_str());
      joint.parent = from.parent;
      std::copy_n(from.rest, FB_FRAME_FLOATS, joint.rest.begin());
      std::copy_n(from.inverse_bind, FB_FRAME_FLOATS, joint.inverse_bind.begin());
    }
    check_rules([&] { set_default_inverse_bind(character.joints); });
    if (rig.skin_influences == 0) return;
    if (rig.skin_influences > FB_MOST_INFLUENCES)
      fail(Status::rig, "%s: skin_influences is %u, more than %u", label.c_str(), rig.skin_influences,
           FB_MOST_INFLUENCES);
    const std::size_t places = std::size_t{rig.vertex_count} * rig.skin_influences;
    const std::uint16_t* of_vertices = array(rig.skin_joints, rig.skin_influences, "skin_joints", "skin_influences");
    const float* weights = array(rig.skin_weights, rig.skin_influences, "skin_weights", "skin_influences");
    character.skin = {rig.skin_influences, {of_vertices, of_vertices + places}, {weights, weights + places}};
    tidy(character.skin);
  }

  // Of each joint.
  std::vector<std::uint32_t> joint_numbers(const fb_rig& rig) const {
    std::vector<std::uint32_t> numbers(rig.joint_count);
    if (rig.struct_size < rig_with_numbers || !rig.joint_numbers) return numbers;
    if (!(rig.flags & FB_RIG_SKINNED)) fail(Status::rig, "%s: joint_numbers without FB_RIG_SKINNED", label.c_str());
    std::copy_n(rig.joint_numbers, rig.joint_count, numbers.begin());
    for (std::size_t j = 0; j < numbers.size(); ++j)
      if ((numbers[j] & ~joint_numbers_of_rigs) != 0)
        fail(Status::rig, "%s: joint_numbers of joint %zu is %#x; a rig has FB_JOINT_ROTATE, _MOVE and _SCALE only",
             label.c_str(), j, numbers[j]);
    return numbers;
  }

  void take_out_skin_of(const fb_rig& rig, RigDescription& description) const {
    if (!rig.evaluate_skinned) fail(Status::rig, "%s: evaluate_skinned is null", label.c_str());
    if (description.character.skin.influences == 0)
      fail(Status::rig, "%s: FB_RIG_SKINNED without a skin", label.c_str());
    const std::vector<std::uint32_t> numbers = joint_numbers(rig);
    check_rules([&] { take_out_skin(description, numbers); });
  }

  std::vector<Channel> channels(const fb_rig& rig) const {
    std::vector<Channel> channels;
    const fb_channel* from = array(rig.channels, rig.channel_count, "channels", "channel_count");
    check_stride<fb_channel>(rig.channel_stride, "channel_stride", "fb_channel");
    if (!rig.evaluate_all && !(rig.flags & FB_RIG_SKINNED))
      fail(Status::rig, "%s: evaluate_all is null", label.c_str());
    for (std::uint32_t i = 0; i < rig.channel_count; ++i) {
      const fb_channel& c = element(from, rig.channel_stride, i);
      channels.push_back({text(c.name, format("the name of channel %u", i).c_str()), c.unit ? c.unit : "", c.minimum,
                          c.maximum, c.rest});
    }
    return channels;
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

// What a version says of a skin that is taken out of positions: with another, they are others.
std::string skin_version(const Character& character, const DrivenJoints& driven) {
  std::uint64_t hash = hash64_of<std::uint16_t>(character.skin.joints, hash64_of<float>(character.skin.weights));
  for (const Joint& joint : character.joints) hash = hash64_of<float>(joint.inverse_bind, hash);
  if (!driven.empty()) {
    hash = hash64_of<std::uint16_t>(driven.skin.joints, hash64_of<float>(driven.skin.weights, hash));
    for (const DrivenJoint& joint : driven.joints) {
      const std::uint32_t numbers[] = {joint.parent, joint.numbers};
      hash = hash64_of<std::uint32_t>(numbers, hash64_of<float>(joint.rest, hash));
    }
  }
  return format(" (skin %016llx)", static_cast<unsigned long long>(hash));
}

}  // namespace

void take_out_skin(RigDescription& rig, std::span<const std::uint32_t> numbers) {
  Character& character = rig.character;
  if (character.skin.influences == 0) fail(Status::bad_data, "positions after skinning, without a skin");
  check(rig.rest);
  check(character.joints, character.skin, rig.rest, all_driven(character.joints, numbers));
  rig.joints = part_joints(numbers, character, rig.rest);
  rig.skinned = true;
  rig.version += skin_version(character, rig.rest.driven);
}

void take_out_poses(const RigDescription& rig, std::span<float> positions, std::span<const float> channels,
                    std::span<const float> frames, std::size_t poses, std::span<float> points) {
  const Mesh& rest = rig.rest;
  const std::size_t size = 3 * rest.surface_vertex_count(), joints = rig.joints.count();
  const std::size_t of_channels = rig.schema.channels.size(), numbers = carried_count(rig.schema, rest);
  std::vector<float> carried(poses * numbers);
  std::vector<Frame<double>> of_pose(joints);
  for (std::size_t p = 0; p < poses; ++p) {
    for (std::size_t j = 0; j < joints; ++j)
      std::ranges::copy(frames.subspan(12 * (p * joints + j), 12), of_pose[j].begin());
    const std::span<float> here = std::span(carried).subspan(p * numbers, numbers);
    std::ranges::copy(channels.subspan(p * of_channels, of_channels), here.begin());
    try {
      take_out_joints(rig.joints, rig.character, rest, of_pose, positions.subspan(p * size, size),
                      here.subspan(of_channels));
    } catch (const Error& error) {
      throw PoseError(Status::rig, p, error.what());
    }
  }
  join_carried(rig.schema, rest, positions, carried, poses, points);
}

RigDescription describe(const fb_rig& rig) {
  Reader reader;
  if (rig.abi != FB_RIG_ABI)
    fail(Status::unsupported, "rig: made for rig ABI %u, this library has rig ABI %u: compile it against its header",
         rig.abi, unsigned{FB_RIG_ABI});
  if (rig.struct_size < smallest_rig)
    fail(Status::rig, "rig: struct_size is %u, less than the %zu bytes of an fb_rig", rig.struct_size, smallest_rig);
  reader.label = format("rig \"%s\"", reader.text(rig.name, "name"));
  const bool channels = rig.struct_size >= rig_with_channels && rig.channel_count > 0;
  const bool joints = rig.struct_size >= rig_with_joints, skinned = (rig.flags & FB_RIG_SKINNED) != 0;
  if (skinned && !joints)
    fail(Status::rig, "%s: FB_RIG_SKINNED, and a struct_size of %u that ends before evaluate_skinned",
         reader.label.c_str(), rig.struct_size);
  if (!rig.evaluate && !channels && !skinned) fail(Status::rig, "%s: evaluate is null", reader.label.c_str());
  RigDescription description;
  description.schema = reader.schema(rig);
  description.rest = reader.mesh(rig);
  if (rig.struct_size >= rig_with_version && rig.version) description.version = rig.version;
  if (rig.struct_size >= rig_with_character) {
    reader.read_labels(rig, description.schema);
    description.rest.parts = reader.parts(rig);
    if (joints) reader.read_joints(rig, description.character);
    if (skinned) reader.take_out_skin_of(rig, description);
    reader.read_character(rig, description.rest, description.character);
  }
  if (rig.struct_size >= rig_with_about && rig.about)
    reader.check_rules([&] { description.character.about = merged_about(rig.about, ""); });
  reader.check_rules([&] { check_source(description.schema, description.rest, description.character); });
  if (channels) {
    description.schema.channels = reader.channels(rig);
    add_channel_vertices(description.schema, description.rest);
    reader.check_rules([&] { check(description.schema); });
  }
  if (!description.rest.driven.empty()) {
    add_joint_vertices(description.rest);
    reader.check_rules([&] { check(description.rest); });
  }
  if (rig.clip_count > 0) {
    if (!rig.clips) fail(Status::rig, "%s: clips is null", reader.label.c_str());
    reader.check_stride<fb_rig_clip>(rig.clip_stride, "clip_stride", "fb_rig_clip");
  }
  for (std::uint32_t i = 0; i < rig.clip_count; ++i)
    description.clips.push_back(reader.clip(element(rig.clips, rig.clip_stride, i), i, description.schema));
  reader.check_rules([&] { check_clips(description.clips); });
  if (rig.struct_size >= rig_with_block)
    description.preferred_block = std::min<std::size_t>(rig.preferred_block, most_preferred_poses);
  return description;
}

}  // namespace fb::bake
