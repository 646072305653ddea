#include "support/plugin_rig.h"

#include <algorithm>
#include <cstdio>
#include <new>
#include <stdexcept>

namespace rigs {
namespace {

void explain(char* message, std::uint32_t size, const char* sentence) {
  if (message && size) std::snprintf(message, size, "%s", sentence);
}

}  // namespace

void PluginRig::add_control(const std::string& name, const std::string& group, float minimum, float maximum) {
  controls_.push_back({keep(name), keep(group), minimum, maximum, 0.0f, 0});
}

void PluginRig::set_mesh(const Array<float>& rest, const Array<std::int32_t>& faces) {
  rest_ = rest.values;
  for (std::size_t corner = 0; corner < faces.values.size(); ++corner) {
    if (corner % 4 == 0) polygon_sizes_.push_back(0);
    const std::int32_t vertex = faces.values[corner];
    if (vertex == -1) continue;
    if (vertex < 0 || static_cast<std::size_t>(vertex) >= vertices())
      throw std::runtime_error("face " + std::to_string(corner / 4) + " has no vertex " + std::to_string(vertex));
    polygon_corners_.push_back(vertex);
    ++polygon_sizes_.back();
  }
}

void PluginRig::add_clip(const std::string& name, std::int32_t kind, std::int32_t split, double fps,
                         std::vector<float> frames) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const fb_rig_control& control = controls_[i % controls_.size()];
    frames[i] = std::clamp(frames[i], control.minimum, control.maximum);
  }
  const auto count = static_cast<std::uint32_t>(frames.size() / controls_.size());
  curves_.push_back(std::move(frames));
  clips_.push_back({keep(name), kind, split, fps, count, 0, curves_.back().data()});
}

void PluginRig::evaluate_skinned(const float* controls, float* positions, float*) const {
  evaluate(controls, positions);
}

void PluginRig::add_joint(const std::string& name, std::ptrdiff_t parent, const float* origin, std::uint32_t numbers) {
  fb_joint joint = {};
  joint.name = keep(name);
  joint.parent = parent < 0 ? FB_NO_JOINT : static_cast<std::uint32_t>(parent);
  for (int axis = 0; axis < 3; ++axis) {
    joint.rest[5 * axis] = 1;
    joint.rest[4 * axis + 3] = origin[axis];
    // At rest all axes are those of space.
    if (parent >= 0) joint.rest[4 * axis + 3] += joints_[parent].inverse_bind[4 * axis + 3];
    joint.inverse_bind[5 * axis] = 1;
    joint.inverse_bind[4 * axis + 3] = -origin[axis];
  }
  joints_.push_back(joint);
  joint_numbers_.push_back(numbers);
}

void PluginRig::set_skin(const Array<float>& weights) {
  const std::size_t joints = weights.shape[1];
  for (std::size_t v = 0; v < vertices(); ++v) {
    const float* const of = weights.values.data() + v * joints;
    influences_ = std::max(influences_,
                           static_cast<std::uint32_t>(std::count_if(of, of + joints, [](float w) { return w > 0; })));
  }
  for (std::size_t v = 0; v < vertices(); ++v) {
    const std::size_t end = (v + 1) * influences_;
    for (std::size_t j = 0; j < joints; ++j)
      if (const float weight = weights.values[v * joints + j]; weight > 0) {
        skin_joints_.push_back(static_cast<std::uint16_t>(j));
        skin_weights_.push_back(weight);
      }
    skin_joints_.resize(end);
    skin_weights_.resize(end);
  }
}

void PluginRig::hand_over(std::unique_ptr<PluginRig> self, fb_rig* rig) {
  fb_rig_init(rig);
  rig->name = self->name_.c_str();
  rig->units = self->units_.c_str();
  rig->up_axis = "y";
  rig->flags = FB_RIG_THREAD_SAFE;
  rig->control_count = static_cast<std::uint32_t>(self->controls_.size());
  rig->controls = self->controls_.data();
  rig->vertex_count = static_cast<std::uint32_t>(self->vertices());
  rig->polygon_count = static_cast<std::uint32_t>(self->polygon_sizes_.size());
  rig->rest_positions = self->rest_.data();
  rig->polygon_sizes = self->polygon_sizes_.data();
  rig->polygon_corners = self->polygon_corners_.data();
  rig->clip_count = static_cast<std::uint32_t>(self->clips_.size());
  rig->clips = self->clips_.data();
  rig->evaluate = [](void* user, std::uint64_t poses, const float* controls, float* positions, char* message,
                     std::uint32_t message_size) -> fb_status {
    try {
      const auto& rig = *static_cast<const PluginRig*>(user);
      for (std::uint64_t pose = 0; pose < poses; ++pose)
        rig.evaluate(controls + pose * rig.controls_.size(), positions + pose * rig.rest_.size());
      return FB_OK;
    } catch (const std::bad_alloc&) {
      explain(message, message_size, "no memory left to evaluate a pose");
      return FB_ERROR_OUT_OF_MEMORY;
    }
  };
  if (!self->joints_.empty()) {
    rig->flags |= FB_RIG_SKINNED;
    rig->joint_count = static_cast<std::uint32_t>(self->joints_.size());
    rig->joints = self->joints_.data();
    rig->joint_numbers = self->joint_numbers_.data();
    rig->skin_influences = self->influences_;
    rig->skin_joints = self->skin_joints_.data();
    rig->skin_weights = self->skin_weights_.data();
    rig->evaluate_skinned = [](void* user, std::uint64_t poses, const float* controls, float* positions, float*,
                               float* frames, char* message, std::uint32_t message_size) -> fb_status {
      try {
        const auto& rig = *static_cast<const PluginRig*>(user);
        for (std::uint64_t pose = 0; pose < poses; ++pose)
          rig.evaluate_skinned(controls + pose * rig.controls_.size(), positions + pose * rig.rest_.size(),
                               frames + pose * FB_FRAME_FLOATS * rig.joints_.size());
        return FB_OK;
      } catch (const std::bad_alloc&) {
        explain(message, message_size, "no memory left to evaluate a pose");
        return FB_ERROR_OUT_OF_MEMORY;
      }
    };
  }
  rig->destroy = [](void* user) { delete static_cast<PluginRig*>(user); };
  rig->user = self.release();
}

fb_status open_plugin(const char* folder, std::unique_ptr<PluginRig> (*make)(const RigFolder&), fb_rig* rig,
                      char* message, std::uint32_t message_size) {
  try {
    const RigFolder data(folder);
    PluginRig::hand_over(make(data), rig);
    return FB_OK;
  } catch (const std::exception& error) {
    explain(message, message_size, error.what());
    return FB_ERROR_RIG;
  }
}

}  // namespace rigs
