#include "face_system.h"

#include <facebaker/facebaker_character.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace engine {
namespace {

// Details between two levels: batches are of equal detail, so it goes in steps.
constexpr std::uint32_t steps_per_level = 4;

Vector operator-(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
float dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
float length(const Vector& a) {
  return std::sqrt(dot(a, a));
}

Bounds moved(Bounds bounds, const Vector& by) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bounds.low[axis] += by[axis];
    bounds.high[axis] += by[axis];
  }
  return bounds;
}

Vector centre(const Bounds& b) {
  return {(b.low[0] + b.high[0]) / 2, (b.low[1] + b.high[1]) / 2, (b.low[2] + b.high[2]) / 2};
}

Bounds bounds_of(const float* positions, std::size_t vertices) {
  Bounds bounds;
  for (std::size_t i = 0; i < 3 * vertices; ++i) {
    bounds.low[i % 3] = i < 3 ? positions[i] : std::min(bounds.low[i % 3], positions[i]);
    bounds.high[i % 3] = i < 3 ? positions[i] : std::max(bounds.high[i % 3], positions[i]);
  }
  return bounds;
}

}  // namespace

std::unique_ptr<FaceSystem> FaceSystem::create(const char* path, std::uint32_t capacity, HostAllocator& allocator,
                                               JobSystem& jobs, std::string& error) {
  std::unique_ptr<FaceSystem> made(new FaceSystem);
  FaceSystem& s = *made;
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.allocator = allocator.callbacks();
  if (fb_load(path, &desc, &s.model_) != FB_OK || fb_scratch_create(s.model_, jobs.workers(), &s.scratch_) != FB_OK) {
    error = fb_last_error();
    return nullptr;
  }
  s.jobs_ = &jobs;
  s.capacity_ = capacity;
  s.control_count_ = fb_control_count(s.model_);
  s.vertex_count_ = fb_vertex_count(s.model_);
  for (std::uint32_t index = 0; index < fb_level_count(s.model_); ++index) {
    fb_level level;
    fb_level_init(&level);
    fb_level_at(s.model_, index, &level);
    s.level_vertices_.push_back(level.vertex_count);
  }
  s.rest_bounds_ = bounds_of(fb_rest_positions(s.model_), s.vertex_count_);
  // How far a face may move between two frames without being lost to the camera.
  s.radius_margin_ = static_cast<float>(fb_diagonal(s.model_)) / 4;
  s.instances_.reserve(capacity);
  s.entries_.reserve(capacity);
  s.unknown_.reserve(capacity);
  for (auto* numbers : {&s.controls_, &s.last_controls_, &s.batch_controls_})
    numbers->resize(capacity * s.control_count_);
  for (auto* numbers : {&s.positions_, &s.last_positions_, &s.history_, &s.normals_})
    numbers->resize(capacity * 3 * s.vertex_count_);
  s.batch_bounds_.resize(6 * std::size_t(capacity));
  return made;
}

FaceSystem::~FaceSystem() {
  fb_scratch_destroy(scratch_);
  fb_release(model_);
}

std::uint32_t FaceSystem::add(const Vector& place) {
  const std::uint32_t index = size();
  assert(index < capacity_);
  Instance instance;
  instance.place = place;
  instance.bounds = rest_bounds_;
  instances_.push_back(instance);
  std::copy_n(fb_rest_controls(model_), control_count_, controls(index));
  std::copy_n(fb_rest_controls(model_), control_count_, last_controls_.data() + index * control_count_);
  return index;
}

// A sphere around the bounds against the camera's cone.
bool FaceSystem::is_seen(const Camera& camera, const Instance& instance) const {
  const Bounds bounds = moved(instance.bounds, instance.place);
  const float radius = length(bounds.high - bounds.low) / 2 + radius_margin_;
  const Vector to = centre(bounds) - camera.position;
  const float ahead = dot(to, camera.direction);
  const float aside = std::sqrt(std::max(0.0f, dot(to, to) - ahead * ahead));
  return aside * std::cos(camera.half_angle) - ahead * std::sin(camera.half_angle) <= radius && ahead > -radius;
}

// Which instances are posed, and in what detail: finest first, so that groups are neighbours.
void FaceSystem::choose(const Camera& camera) {
  const float coarsest = static_cast<float>(level_vertices_.size() - 1);
  entries_.clear();
  for (std::uint32_t i = 0; i < size(); ++i) {
    Instance& instance = instances_[i];
    instance.view = {};
    if (!is_seen(camera, instance)) continue;
    const float distance = length(centre(moved(instance.bounds, instance.place)) - camera.position);
    const float lod = distance > 0 ? std::log2(distance / camera.full_detail_distance) : 0;
    const float steps = std::floor(std::clamp(lod, 0.0f, coarsest) * steps_per_level);
    entries_.push_back({static_cast<std::uint32_t>(steps), i});
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return a.steps != b.steps ? a.steps < b.steps : a.instance < b.instance;
  });
}

bool FaceSystem::pose_batch(const Entry* entries, std::size_t first, std::size_t count, Pose pose, std::string& error) {
  const bool is_last = pose == Pose::last;
  const std::uint32_t steps = entries->steps, level = steps / steps_per_level;
  const std::size_t floats = 3 * std::size_t(level_vertices_[level]), offset = first * 3 * vertex_count_;
  float* const positions = (is_last ? history_ : positions_).data() + offset;
  for (std::size_t k = 0; k < count; ++k)
    std::copy_n((is_last ? last_controls_ : controls_).data() + entries[k].instance * control_count_, control_count_,
                batch_controls_.data() + k * control_count_);
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = count;
  batch.controls = batch_controls_.data();
  batch.control_floats = count * control_count_;
  batch.positions = positions;
  batch.position_floats = count * floats;
  batch.pose_stride = floats;
  batch.vertex_order = FB_ORDER_BAKED;
  batch.lod = static_cast<float>(steps) / steps_per_level;
  batch.level_only = 1;
  batch.parallel_for = JobSystem::parallel_for;
  batch.parallel_user = jobs_;
  if (!is_last) {
    batch.normals = normals_.data() + offset;
    batch.normal_numbers = count * floats;
    batch.normal_pose_stride = floats;
    batch.bounds = batch_bounds_.data();
    batch.bounds_floats = 6 * count;
  }
  if (fb_evaluate_batch(model_, scratch_, &batch) != FB_OK) {
    error = fb_last_error();
    return false;
  }
  posed_ += static_cast<std::uint32_t>(count);
  for (std::size_t k = 0; k < count; ++k) {
    Instance& instance = instances_[entries[k].instance];
    FaceView& view = instance.view;
    if (is_last) {
      view.previous = positions + k * floats;
      continue;
    }
    const float* const b = batch_bounds_.data() + 6 * k;
    instance.bounds = {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
    view.visible = true;
    view.lod = batch.lod;
    view.level = level;
    view.vertices = level_vertices_[level];
    view.positions = positions + k * floats;
    view.normals = normals_.data() + offset + k * floats;
    view.bounds = moved(instance.bounds, instance.place);
  }
  return true;
}

bool FaceSystem::pose_all(const std::vector<Entry>& entries, Pose pose, std::string& error) {
  for (std::size_t first = 0, count = 0; first < entries.size(); first += count) {
    for (count = 1; first + count < entries.size() && entries[first + count].steps == entries[first].steps;) ++count;
    if (!pose_batch(entries.data() + first, first, count, pose, error)) return false;
  }
  return true;
}

bool FaceSystem::update(const Camera& camera, std::string& error) {
  ++frame_;
  posed_ = 0;
  positions_.swap(last_positions_);  // which pointers into them follow
  for (Instance& instance : instances_) instance.last_positions = instance.view.positions;
  choose(camera);
  if (!pose_all(entries_, Pose::current, error)) return false;
  // Positions of the last frame serve where the detail is the same; elsewhere its pose is evaluated again, so that a
  // change of detail is no motion.
  unknown_.clear();
  for (const Entry& entry : entries_) {
    Instance& instance = instances_[entry.instance];
    instance.view.previous = instance.last_positions;
    if (instance.last_frame + 1 != frame_ || instance.last_steps != entry.steps) unknown_.push_back(entry);
    instance.last_frame = frame_;
    instance.last_steps = entry.steps;
  }
  if (!pose_all(unknown_, Pose::last, error)) return false;
  std::copy_n(controls_.data(), size() * control_count_, last_controls_.data());
  return true;
}

}  // namespace engine
