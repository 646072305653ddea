#include "face_pose.h"

#include <facebaker/facebaker_character.h>

#include <algorithm>
#include <map>
#include <utility>

namespace facebaker::engine {

namespace {

// By model, those that FacePoses use now.
std::mutex known_mutex;
std::map<const fb_model*, std::weak_ptr<SharedScratches>> known;

}  // namespace

std::shared_ptr<SharedScratches> SharedScratches::of(const Model& model) {
  const std::lock_guard lock(known_mutex);
  for (auto entry = known.begin(); entry != known.end();)
    entry = entry->second.expired() ? known.erase(entry) : ++entry;
  std::weak_ptr<SharedScratches>& entry = known[model.get()];
  std::shared_ptr<SharedScratches> made = entry.lock();
  if (!made) entry = made = std::shared_ptr<SharedScratches>(new SharedScratches(model));
  return made;
}

void SharedScratches::evaluate(const fb_batch_desc& batch) {
  std::unique_ptr<Scratch> scratch;
  {
    const std::lock_guard lock(mutex_);
    if (!free_.empty()) {
      scratch = std::move(free_.back());
      free_.pop_back();
    }
  }
  if (!scratch) scratch = std::make_unique<Scratch>(model_);
  const auto give_back = [&] {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(scratch));
  };
  try {
    scratch->evaluate(batch);
  } catch (...) {
    give_back();
    throw;
  }
  give_back();
}

std::size_t SharedScratches::scratch_count() {
  const std::lock_guard lock(mutex_);
  return free_.size();
}

FacePose::FacePose(const Model& model)
    : model_(model), scratches_(SharedScratches::of(model)), controls_(model.rest_controls()) {
  for (std::uint32_t i = 0; i < fb_level_count(model.get()); ++i) {
    fb_level level;
    fb_level_init(&level);
    check(fb_level_at(model.get(), i, &level));
    level_vertices_.push_back(level.vertex_count);
  }
  pose();
  previous_ = current_;
}

bool FacePose::set_control(std::uint32_t index, float value) {
  if (index >= controls_.size()) return false;
  // NaN differs from itself, and so is reported by every pose until it is gone.
  if (controls_[index] != value) changed_ = true;
  controls_[index] = value;
  return true;
}

bool FacePose::set_controls(const float* values, std::size_t count) {
  if (count != controls_.size()) return false;
  for (std::uint32_t i = 0; i < count; ++i) set_control(i, values[i]);
  return true;
}

void FacePose::set_lod(float lod) {
  changed_ = changed_ || lod != lod_;
  lod_ = lod;
}

void FacePose::set_level_only(bool level_only) {
  changed_ = changed_ || level_only != level_only_;
  level_only_ = level_only;
}

void FacePose::write_positions(std::vector<float>& to) const {
  to.resize(3 * static_cast<std::size_t>(model_.vertex_count()));
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = 1;
  batch.controls = current_->controls.data();
  batch.control_floats = current_->controls.size();
  batch.positions = to.data();
  batch.position_floats = to.size();
  batch.lod = current_->lod;
  scratches_->evaluate(batch);
}

// One that nobody reads: only frames_ holds it.
std::shared_ptr<PosedFrame> FacePose::free_frame() {
  const auto found =
      std::find_if(frames_.begin(), frames_.end(), [](const auto& frame) { return frame.use_count() == 1; });
  if (found != frames_.end()) {
    // The count that is read above orders nothing; letting go of a copy does: what another thread has read of the
    // frame, it read before it let go of it.
    std::shared_ptr<PosedFrame>(*found).reset();
    return *found;
  }
  const auto frame = std::make_shared<PosedFrame>();
  const std::size_t numbers = 3 * static_cast<std::size_t>(model_.vertex_count());
  frame->positions.resize(numbers);
  frame->normals.resize(numbers);
  if (fb_tangent_signs(model_.get())) frame->tangents.resize(numbers);
  frame->sockets.resize(static_cast<std::size_t>(FB_FRAME_FLOATS) * fb_socket_count(model_.get()));
  frame->driven_joints.resize(static_cast<std::size_t>(FB_FRAME_FLOATS) * fb_driven_joint_count(model_.get()));
  frames_.push_back(frame);
  return frame;
}

bool FacePose::pose() {
  if (!changed_) {
    previous_ = current_;
    return false;
  }
  const std::shared_ptr<PosedFrame> frame = free_frame();
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = 1;
  batch.controls = controls_.data();
  batch.control_floats = controls_.size();
  batch.positions = frame->positions.data();
  batch.position_floats = frame->positions.size();
  batch.normals = frame->normals.data();
  batch.normal_numbers = frame->normals.size();
  batch.tangents = frame->tangents.empty() ? nullptr : frame->tangents.data();
  batch.tangent_numbers = frame->tangents.size();
  batch.sockets = frame->sockets.empty() ? nullptr : frame->sockets.data();
  batch.socket_floats = frame->sockets.size();
  batch.joints = frame->driven_joints.empty() ? nullptr : frame->driven_joints.data();
  batch.joint_floats = frame->driven_joints.size();
  batch.bounds = frame->bounds.data();
  batch.bounds_floats = frame->bounds.size();
  batch.lod = lod_;
  batch.level_only = level_only_ ? 1 : 0;
  batch.vertex_order = level_only_ ? FB_ORDER_BAKED : FB_ORDER_SOURCE;
  scratches_->evaluate(batch);
  frame->controls = controls_;
  frame->lod = lod_;
  frame->level = static_cast<std::uint32_t>(std::min(lod_, static_cast<float>(level_vertices_.size() - 1)));
  frame->baked = level_only_;
  frame->vertex_count = level_vertices_[level_only_ ? frame->level : 0];
  frame->number = current_ ? current_->number + 1 : 1;
  previous_ = current_;
  current_ = frame;
  changed_ = false;
  return true;
}

}  // namespace facebaker::engine
