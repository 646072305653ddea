// The production rig as a plugin. In FB_RIG_SLEEP_MS of the environment, milliseconds, each pose takes so much longer:
// a rig in a DCC answers in 100 to 1,000.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "production/face_poses.h"
#include "production/face_rig.h"
#include "support/plugin_rig.h"

namespace rigs::production {
namespace {

constexpr std::size_t random_test_poses = 500;
constexpr std::uint64_t test_seed = 0x7e57;

std::chrono::duration<double, std::milli> sleep_of_environment() {
  const char* text = std::getenv("FB_RIG_SLEEP_MS");
  return std::chrono::duration<double, std::milli>(text ? std::strtod(text, nullptr) : 0);
}

class Production : public PluginRig {
 public:
  Production() : PluginRig("production", "cm"), sleep_(sleep_of_environment()) {
    const FaceMesh& mesh = rig_.mesh();
    Array<float> rest{{mesh.points.size(), 3}, {}};
    for (const Vec p : rig_.rest()) rest.values.insert(rest.values.end(), {p.x, p.y, p.z});
    set_mesh(rest, {{mesh.corners.size() / 4, 4}, mesh.corners});
    for (const ControlRange& c : rig_.controls().list()) add_control(c.name, c.group, c.minimum, c.maximum);
    for (Shot& shot : make_shots(rig_.controls()))
      add_clip(shot.name, FB_CLIP_SHOT, FB_SPLIT_TEST, shot_fps, std::move(shot.frames));
    add_clip("random", FB_CLIP_DENSE, FB_SPLIT_TEST, shot_fps,
             random_poses(rig_.controls(), test_seed, random_test_poses));
  }

  void evaluate(const float* controls, float* positions) const override {
    std::vector<Vec> points(rig_.rest().size());
    rig_.pose(controls, points.data());
    for (const Vec p : points) {
      *positions++ = p.x;
      *positions++ = p.y;
      *positions++ = p.z;
    }
    if (sleep_.count() > 0) std::this_thread::sleep_for(sleep_);
  }

 private:
  FaceRig rig_;
  std::chrono::duration<double, std::milli> sleep_;
};

}  // namespace
}  // namespace rigs::production

extern "C" FB_API fb_status fb_rig_open(const char*, fb_rig* rig, char* message, std::uint32_t message_size) {
  try {
    rigs::PluginRig::hand_over(std::make_unique<rigs::production::Production>(), rig);
    return FB_OK;
  } catch (const std::exception& error) {
    std::snprintf(message, message_size, "the production rig: %s", error.what());
    return FB_ERROR_RIG;
  }
}
