// The sample face behind the rig plugin ABI: the one file that exports a symbol and lets no exception out.
#include <facebaker/facebaker_rig.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <vector>

#include "face_joints.h"
#include "face_labels.h"
#include "face_materials.h"
#include "face_sockets.h"
#include "rig.h"
#include "shots.h"
#include "uv_layout.h"

namespace {

using namespace sample_face;

static_assert(sizeof(Vec3) == 3 * sizeof(float) && sizeof(Uv) == 2 * sizeof(float));

// The rig and the arrays that the ABI's struct points into.
struct Plugin {
  Rig rig;
  std::vector<Shot> shots;
  std::vector<fb_rig_control> controls;
  std::vector<fb_rig_clip> clips;
  std::vector<std::uint32_t> sizes;
  FaceSkin skin;
  std::vector<fb_joint> joints;
  std::vector<std::uint32_t> joint_numbers;
  std::vector<ControlLabels> meanings;
  std::vector<fb_rig_labels> labels;
  FaceUvs uvs;
  std::vector<FaceSocket> holds;
  std::vector<fb_socket> sockets;
  std::vector<fb_material> materials;
  std::vector<fb_material_run> runs;
  fb_texture texture = {FB_TEXTURE_BASE_COLOUR, 0, FB_WRAP_CLAMP, FB_WRAP_CLAMP, 1};
  fb_image image = {};
  fb_mesh mesh = {};

  Plugin()
      : shots(make_shots(rig.controls())),
        meanings(label(rig.controls())),
        uvs(lay_out(rig.mesh())),
        holds(face_sockets(rig.mesh())) {
    for (const Control& c : rig.controls().list())
      controls.push_back({c.name.c_str(), c.group.c_str(), c.two_sided ? -1.0f : 0.0f, 1.0f, 0.0f, 0});
    for (const Shot& s : shots)
      clips.push_back(
          {s.name.c_str(), FB_CLIP_SHOT, std::int32_t(s.split), s.fps, std::uint32_t(s.frames), 0, s.values.data()});
    sizes.assign(rig.mesh().quads.size(), 4);
    skin = face_skin(rig.mesh(), rig.jaw_weight());
    for (const FaceJoint& joint : face_joints()) add_joint(joint);
    for (const ControlLabels& m : meanings)
      labels.push_back({m.arkit.c_str(), m.facs.c_str(), nullptr, m.mirror.c_str()});
    for (const FaceSocket& hold : holds) add_socket(hold);
    add_mesh();
  }

  void add_joint(const FaceJoint& from) {
    fb_joint joint = {};
    joint.name = from.name;
    joint.parent = FB_NO_JOINT;
    for (int row = 0; row < 3; ++row) {
      joint.rest[5 * row] = 1;
      joint.rest[4 * row + 3] = (&from.origin.x)[row];
    }
    joints.push_back(joint);
    joint_numbers.push_back(from.numbers);
  }

  void add_socket(const FaceSocket& from) {
    fb_socket socket = {};
    socket.name = from.name.c_str();
    socket.vertices = from.vertices.data();
    socket.vertex_count = std::uint32_t(from.vertices.size());
    for (int row = 0; row < 3; ++row) {
      socket.frame[5 * row] = 1;
      socket.frame[4 * row + 3] = (&from.origin.x)[row];
    }
    sockets.push_back(socket);
  }

  // One mesh of four materials, which share a picture.
  void add_mesh() {
    image.name = "face_colour";
    image.media_type = "image/png";
    image.bytes = face_colour().data();
    image.byte_count = face_colour().size();
    for (const FaceMaterial& from : face_materials()) {
      fb_material material = {};
      material.name = from.name;
      std::ranges::copy(from.colour, material.base_colour);
      material.base_colour[3] = 1;
      material.roughness = from.roughness;
      material.alpha_cutoff = 0.5f;
      material.texture_count = 1;
      material.textures = &texture;
      materials.push_back(material);
    }
    for (const std::uint32_t quads : material_quads(rig.mesh())) runs.push_back({quads, std::uint32_t(runs.size())});
    mesh.name = "head";
    mesh.vertex_count = std::uint32_t(rig.rest().size());
    mesh.polygon_count = std::uint32_t(rig.mesh().quads.size());
    mesh.runs = runs.data();
    mesh.run_count = std::uint32_t(runs.size());
  }
};

fb_status evaluate(void* user, uint64_t poses, const float* controls, float* positions, float*, float* joints, char*,
                   uint32_t) {
  const Rig& rig = static_cast<const Plugin*>(user)->rig;
  const std::size_t width = rig.controls().list().size(), count = rig.rest().size();
  Vec3* points = reinterpret_cast<Vec3*>(positions);
  constexpr std::size_t frames = FB_FRAME_FLOATS * std::size_t(kFaceJoints);
  for (uint64_t i = 0; i < poses; ++i) {
    rig.pose(controls + i * width, points + i * count);
    joint_frames(rig.motions(), controls + i * width, joints + i * frames);
  }
  return FB_OK;
}

void destroy(void* user) {
  delete static_cast<Plugin*>(user);
}

void fill(const Plugin& plugin, fb_rig& rig) {
  const FaceMesh& mesh = plugin.rig.mesh();
  fb_rig_init(&rig);
  rig.name = "sample face";
  rig.units = "cm";
  rig.up_axis = "y";
  rig.flags = FB_RIG_THREAD_SAFE | FB_RIG_SKINNED;
  rig.control_count = uint32_t(plugin.controls.size());
  rig.controls = plugin.controls.data();
  rig.vertex_count = uint32_t(plugin.rig.rest().size());
  rig.polygon_count = uint32_t(mesh.quads.size());
  rig.rest_positions = &plugin.rig.rest().front().x;
  rig.polygon_sizes = plugin.sizes.data();
  rig.polygon_corners = mesh.quads.front().data();
  rig.uv_count = uint32_t(plugin.uvs.pairs.size());
  rig.uvs = &plugin.uvs.pairs.front().u;
  rig.uv_corners = plugin.uvs.corners.front().data();
  rig.mesh_count = 1;
  rig.meshes = &plugin.mesh;
  rig.material_count = uint32_t(plugin.materials.size());
  rig.materials = plugin.materials.data();
  rig.image_count = 1;
  rig.images = &plugin.image;
  rig.labels = plugin.labels.data();
  rig.socket_count = uint32_t(plugin.sockets.size());
  rig.sockets = plugin.sockets.data();
  rig.clip_count = uint32_t(plugin.clips.size());
  rig.clips = plugin.clips.data();
  rig.joint_count = uint32_t(plugin.joints.size());
  rig.joints = plugin.joints.data();
  rig.joint_numbers = plugin.joint_numbers.data();
  rig.skin_influences = 1;
  rig.skin_joints = plugin.skin.joints.data();
  rig.skin_weights = plugin.skin.weights.data();
  rig.evaluate_skinned = evaluate;
  rig.destroy = destroy;
}

}  // namespace

extern "C" FB_API fb_status fb_rig_open(const char*, fb_rig* rig, char* message, uint32_t message_size) {
  try {
    auto plugin = std::make_unique<Plugin>();
    fill(*plugin, *rig);
    rig->user = plugin.release();
    return FB_OK;
  } catch (const std::bad_alloc&) {
    std::snprintf(message, message_size, "sample face: out of memory");
    return FB_ERROR_OUT_OF_MEMORY;
  } catch (const std::exception& e) {
    std::snprintf(message, message_size, "sample face: %s", e.what());
    return FB_ERROR_RIG;
  }
}
