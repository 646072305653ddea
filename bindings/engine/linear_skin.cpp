#include "linear_skin.h"

#include <facebaker/facebaker_character.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace facebaker::engine {
namespace {

using Frame = std::array<float, FB_FRAME_FLOATS>;

// a after b.
Frame product(const float* a, const float* b) {
  Frame made{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column) {
      float sum = column == 3 ? a[4 * row + 3] : 0;
      for (std::size_t k = 0; k < 3; ++k) sum += a[4 * row + k] * b[4 * k + column];
      made[4 * row + column] = sum;
    }
  return made;
}

void add_scaled(Frame& sum, float weight, const float* matrix) {
  for (std::size_t k = 0; k < FB_FRAME_FLOATS; ++k) sum[k] += weight * matrix[k];
}

void turn(const float* frame, const float* direction, float* to) {
  float turned[3], square = 0;
  for (std::size_t row = 0; row < 3; ++row) {
    turned[row] = 0;
    for (std::size_t k = 0; k < 3; ++k) turned[row] += frame[4 * row + k] * direction[k];
    square += turned[row] * turned[row];
  }
  const float length = std::sqrt(square);
  for (std::size_t row = 0; row < 3; ++row) to[row] = length > 0 ? turned[row] / length : 0;
}

void move(const float* frame, const float* point, float* to) {
  for (std::size_t row = 0; row < 3; ++row)
    to[row] =
        frame[4 * row] * point[0] + frame[4 * row + 1] * point[1] + frame[4 * row + 2] * point[2] + frame[4 * row + 3];
}

}  // namespace

LinearSkin::LinearSkin(const Model& model) : vertices_(model.vertex_count()), model_(model) {
  influences_ = fb_skin_influences(model.get());
  if (influences_ == 0) return;
  std::vector<Frame> places;
  for (std::uint32_t i = 0; i < fb_joint_count(model.get()); ++i) {
    fb_joint joint;
    fb_joint_init(&joint);
    check(fb_joint_at(model.get(), i, &joint));
    Frame place;
    if (joint.parent == FB_NO_JOINT)
      std::copy_n(joint.rest, FB_FRAME_FLOATS, place.begin());
    else
      place = product(places[joint.parent].data(), joint.rest);
    places.push_back(place);
    const Frame rest = product(place.data(), joint.inverse_bind);
    at_rest_.insert(at_rest_.end(), rest.begin(), rest.end());
    names_.emplace_back(joint.name);
  }
  matrices_ = at_rest_;
  find_shares();
}

void LinearSkin::find_shares() {
  using Weights = std::map<std::uint32_t, double>;  // of joints of the host
  const auto add = [](Weights& to, const Weights& from) {
    for (const auto& [joint, weight] : from) to[joint] += weight;
  };
  const std::size_t count = fb_driven_joint_count(model_.get()), followed = fb_driven_influences(model_.get());
  std::vector<Weights> own(count), below(count);
  for (std::size_t i = 0; i < vertices_ * followed; ++i) {
    const double weight = static_cast<double>(fb_driven_skin_weights(model_.get())[i]);
    if (weight <= 0) continue;
    const std::size_t first = i / followed * influences_;
    for (std::size_t k = first; k < first + influences_; ++k)
      own[fb_driven_skin_joints(model_.get())[i]][fb_skin_joints(model_.get())[k]] +=
          weight * static_cast<double>(fb_skin_weights(model_.get())[k]);
  }
  std::vector<std::uint32_t> parents(count);
  for (std::size_t j = count; j-- > 0;) {  // parents come first
    fb_driven_joint joint;
    fb_driven_joint_init(&joint);
    check(fb_driven_joint_at(model_.get(), static_cast<std::uint32_t>(j), &joint));
    parents[j] = joint.parent;
    if (own[j].empty()) own[j] = below[j];
    if (joint.parent != FB_NO_JOINT) add(below[joint.parent], own[j]);
  }
  shares_.resize(count);
  for (std::size_t j = 0; j < count; ++j) {
    if (own[j].empty() && parents[j] != FB_NO_JOINT) own[j] = own[parents[j]];
    double sum = 0;
    for (const auto& [joint, weight] : own[j]) sum += weight;
    for (const auto& [joint, weight] : own[j])
      if (weight > 0) shares_[j].push_back({joint, static_cast<float>(weight / sum)});
  }
}

void LinearSkin::move_frame(std::uint32_t driven_joint, const float* frame, float* to) const {
  if (driven_joint >= shares_.size() || shares_[driven_joint].empty()) {
    std::copy_n(frame, FB_FRAME_FLOATS, to);
    return;
  }
  Frame sum{};
  for (const Share& share : shares_[driven_joint])
    add_scaled(sum, share.weight, matrices_.data() + static_cast<std::size_t>(FB_FRAME_FLOATS) * share.joint);
  const Frame moved = product(sum.data(), frame);
  std::copy(moved.begin(), moved.end(), to);
}

bool LinearSkin::set_motion(std::uint32_t joint, const float* motion) {
  if (joint >= names_.size()) return false;
  const std::size_t at = static_cast<std::size_t>(FB_FRAME_FLOATS) * joint;
  const Frame matrix = product(motion, at_rest_.data() + at);
  std::copy(matrix.begin(), matrix.end(), matrices_.begin() + static_cast<std::ptrdiff_t>(at));
  return true;
}

void LinearSkin::apply(const PosedFrame& pose, std::vector<float>& positions, std::vector<float>& normals,
                       std::vector<float>& tangents) const {
  positions = pose.positions;
  normals = pose.normals;
  tangents = pose.tangents;
  if (influences_ == 0) return;
  const std::uint16_t* joints = fb_skin_joints(model_.get());
  const float* weights = fb_skin_weights(model_.get());
  const std::uint32_t* order = pose.baked ? fb_vertex_order(model_.get()) : nullptr;
  for (std::size_t v = 0; v < pose.vertex_count; ++v) {
    const std::size_t first = influences_ * static_cast<std::size_t>(order ? order[v] : v);
    Frame sum{};
    float total = 0;
    for (std::size_t i = first; i < first + influences_ && weights[i] > 0; ++i) {
      add_scaled(sum, weights[i], matrices_.data() + static_cast<std::size_t>(FB_FRAME_FLOATS) * joints[i]);
      total += weights[i];
    }
    if (total <= 0) continue;
    move(sum.data(), pose.positions.data() + 3 * v, positions.data() + 3 * v);
    turn(sum.data(), pose.normals.data() + 3 * v, normals.data() + 3 * v);
    if (!pose.tangents.empty()) turn(sum.data(), pose.tangents.data() + 3 * v, tangents.data() + 3 * v);
  }
}

}  // namespace facebaker::engine
