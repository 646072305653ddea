// The sample face behind the rig plugin ABI: the one file that exports a symbol and lets no exception out.
#include <facebaker/facebaker_rig.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <vector>

#include "face_joints.h"
#include "rig.h"
#include "shots.h"

namespace {

using namespace sample_face;

static_assert(sizeof(Vec3) == 3 * sizeof(float));

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

  Plugin() : shots(make_shots(rig.controls())) {
    for (const Control& c : rig.controls().list())
      controls.push_back({c.name.c_str(), c.group.c_str(), c.two_sided ? -1.0f : 0.0f, 1.0f, 0.0f, 0});
    for (const Shot& s : shots)
      clips.push_back(
          {s.name.c_str(), FB_CLIP_SHOT, std::int32_t(s.split), s.fps, std::uint32_t(s.frames), 0, s.values.data()});
    sizes.assign(rig.mesh().quads.size(), 4);
    skin = face_skin(rig.mesh(), rig.jaw_weight());
    for (const FaceJoint& joint : face_joints()) add_joint(joint);
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
