#include "UnrealFace.h"

#include <facebaker/facebaker_character.h>

#include <exception>

namespace facebaker::unreal {
namespace {

// Keeps the sentence of what was thrown; none where memory is too short for it.
void keep_sentence(const std::exception& exception, std::string& error) noexcept {
  try {
    error = exception.what();
  } catch (...) {
    error.clear();
  }
}

// The index that a function of the C interface finds for a name; -1, and its sentence, if it finds none.
std::int64_t find_name(fb_status (*finder)(const fb_model*, const char*, std::uint32_t*), const fb_model* model,
                       const std::string& name, std::string& error) noexcept {
  std::uint32_t index = 0;
  if (finder(model, name.c_str(), &index) == FB_OK) return index;
  keep_sentence(std::runtime_error(fb_last_error()), error);
  return -1;
}

std::vector<DrivenJoint> read_driven_joints(const fb_model* model, const engine::Axes& axes) {
  std::vector<DrivenJoint> joints(fb_driven_joint_count(model));
  for (std::uint32_t i = 0; i < joints.size(); ++i) {
    fb_driven_joint joint;
    fb_driven_joint_init(&joint);
    check(fb_driven_joint_at(model, i, &joint));
    joints[i].name = joint.name;
    joints[i].parent = joint.parent == FB_NO_JOINT ? -1 : static_cast<std::int32_t>(joint.parent);
    joints[i].numbers = joint.numbers;
    joints[i].outer_rotations = joint.outer_rotations;
    axes.convert_frame(joint.rest, joints[i].rest.data());
  }
  return joints;
}

}  // namespace

std::shared_ptr<const Model> load_archive(const void* bytes, std::size_t size, std::string& error) noexcept {
  try {
    const unsigned char nothing = 0;
    return std::make_shared<const Model>(size > 0 ? bytes : &nothing, size);
  } catch (const std::exception& exception) {
    keep_sentence(exception, error);
    return nullptr;
  }
}

std::unique_ptr<UnrealFace> UnrealFace::make(const Model& model, std::string& error) noexcept {
  try {
    return std::unique_ptr<UnrealFace>(new UnrealFace(model));
  } catch (const std::exception& exception) {
    keep_sentence(exception, error);
    return nullptr;
  }
}

UnrealFace::UnrealFace(const Model& model)
    : axes_(engine::axes_of_unreal(fb_up_axis(model.get()), fb_units(model.get()))),
      pose_(model),
      skin_(model),
      driven_joints_(read_driven_joints(model.get(), axes_)),
      sections_(engine::render_surfaces(model, axes_)),
      buffers_(sections_.size()) {
  for (std::size_t s = 0; s < sections_.size(); ++s) {
    const std::size_t floats = 3 * sections_[s].sources.size();
    buffers_[s].positions.resize(floats);
    buffers_[s].normals.resize(floats);
    if (!sections_[s].uvs.empty()) buffers_[s].tangents.resize(floats);
    buffers_[s].motion.resize(floats);
  }
  pose_.set_level_only(true);
  pose_.pose();
  fill_buffers();
}

std::int64_t UnrealFace::find_control(const std::string& name, std::string& error) const noexcept {
  return find_name(fb_find_control, pose_.model().get(), name, error);
}

std::int64_t UnrealFace::find_driven_joint(const std::string& name, std::string& error) const noexcept {
  return find_name(fb_find_driven_joint, pose_.model().get(), name, error);
}

bool UnrealFace::driven_joint_frame(std::uint32_t joint, float* frame) const {
  if (joint >= driven_joints_.size()) return false;
  const auto pose = pose_.current();
  float moved[FB_FRAME_FLOATS];
  skin_.move_frame(joint, pose->driven_joints.data() + static_cast<std::size_t>(FB_FRAME_FLOATS) * joint, moved);
  axes_.convert_frame(moved, frame);
  return true;
}

bool UnrealFace::set_joint_motion(std::uint32_t joint, const float* motion) {
  float in_archive[12];
  axes_.convert_motion_back(motion, in_archive);
  joints_moved_ = true;
  return skin_.set_motion(joint, in_archive);
}

UnrealFace::Update UnrealFace::update(std::string& error) noexcept {
  try {
    const bool moved = pose_.pose() || joints_moved_;
    if (!moved && !moving_) return Update::unchanged;
    fill_buffers();
    joints_moved_ = false;
    moving_ = moved;
    return Update::changed;
  } catch (const std::exception& exception) {
    keep_sentence(exception, error);
    return Update::failed;
  }
}

void UnrealFace::fill_buffers() {
  skin_.apply(*pose_.current(), positions_, normals_, tangents_);
  for (std::size_t s = 0; s < sections_.size(); ++s) {
    SectionBuffers& buffers = buffers_[s];
    const std::vector<std::uint32_t>& places = sections_[s].places(pose_.current()->baked);
    const std::vector<engine::RenderLevel>& levels = sections_[s].levels;
    const std::uint32_t before = filled_level_ < levels.size() ? levels[filled_level_].vertex_count : 0;
    for (std::size_t i = 0; i < levels[level()].vertex_count; ++i) {
      const std::size_t from = 3 * static_cast<std::size_t>(places[i]);
      float now[3];
      axes_.convert_position(positions_.data() + from, now);
      for (std::size_t k = 0; k < 3; ++k) {
        buffers.motion[3 * i + k] = i < before ? buffers.positions[3 * i + k] - now[k] : 0;
        buffers.positions[3 * i + k] = now[k];
      }
      axes_.convert_direction(normals_.data() + from, buffers.normals.data() + 3 * i);
      if (!buffers.tangents.empty()) axes_.convert_direction(tangents_.data() + from, buffers.tangents.data() + 3 * i);
    }
  }
  filled_level_ = level();
}

}  // namespace facebaker::unreal
