// A rig plugin as a C++ object: subclasses describe themselves and pose; this class speaks the C ABI for them.
#pragma once

#include <facebaker/facebaker_rig.h>

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "support/rig_folder.h"

namespace rigs {

class PluginRig {
 public:
  virtual ~PluginRig() = default;

  // One pose: controls() floats in, 3 x vertices floats out. Called from several threads at once.
  virtual void evaluate(const float* controls, float* positions) const = 0;

  // The same, and where each joint is: 12 floats a joint, the upper rows of a 4 x 4 matrix. Of rigs that have some.
  virtual void evaluate_skinned(const float* controls, float* positions, float* frames) const;

  // Fills *rig with pointers into this object, which rig->destroy then deletes.
  static void hand_over(std::unique_ptr<PluginRig> self, fb_rig* rig);

 protected:
  PluginRig(std::string name, std::string units) : name_(std::move(name)), units_(std::move(units)) {}

  // The rest value is 0.
  void add_control(const std::string& name, const std::string& group, float minimum, float maximum);
  // rest: [V,3]; faces: [F,4], where -1 pads a triangle.
  void set_mesh(const Array<float>& rest, const Array<std::int32_t>& faces);
  // frames: [frames, controls], clamped to the controls' ranges.
  void add_clip(const std::string& name, std::int32_t kind, std::int32_t split, double fps, std::vector<float> frames);

  // A joint that controls move, before those below it. parent: its number, or -1; origin: at rest, with the axes of
  // space; numbers: FB_JOINT_...
  void add_joint(const std::string& name, std::ptrdiff_t parent, const float* origin, std::uint32_t numbers);
  // weights: [V, joints].
  void set_skin(const Array<float>& weights);

  std::size_t vertices() const { return rest_.size() / 3; }
  const std::vector<float>& rest() const { return rest_; }

 private:
  const char* keep(const std::string& text) { return texts_.emplace_back(text).c_str(); }

  std::string name_, units_;
  std::deque<std::string> texts_;
  std::vector<fb_rig_control> controls_;
  std::vector<float> rest_;
  std::vector<std::uint32_t> polygon_sizes_, polygon_corners_;
  std::deque<std::vector<float>> curves_;
  std::vector<fb_rig_clip> clips_;
  std::vector<fb_joint> joints_;
  std::vector<std::uint32_t> joint_numbers_;
  std::vector<std::uint16_t> skin_joints_;
  std::vector<float> skin_weights_;
  std::uint32_t influences_ = 0;
};

// The body of fb_rig_open: opens folder `folder`, hands it to `make`, and turns exceptions into a status and a
// sentence.
fb_status open_plugin(const char* folder, std::unique_ptr<PluginRig> (*make)(const RigFolder&), fb_rig* rig,
                      char* message, std::uint32_t message_size);

}  // namespace rigs
