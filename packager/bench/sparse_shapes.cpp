#include "bench/sparse_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fb::tool {

void SparseShapes::Shape::add(float weight, float* positions) const {
  const float* delta = deltas.data();
  for (const std::uint32_t vertex : vertices) {
    float* const to = positions + 4 * std::size_t(vertex);
    float sums[4];  // before any is stored, or compilers cannot tell that a delta is no position
    for (int k = 0; k < 4; ++k) sums[k] = to[k] + weight * delta[k];
    std::copy_n(sums, 4, to);
    delta += 4;
  }
}

std::size_t SparseShapes::Shape::bytes() const {
  return vertices.size() * sizeof(std::uint32_t) + deltas.size() * sizeof(float);
}

float SparseShapes::End::weight(float control_value) const {
  return std::clamp((control_value - rest) / (value - rest), 0.0f, 1.0f);
}

SparseShapes::SparseShapes(const facebaker::Model& model, std::span<const float> controls)
    : model_(model),
      scratch_(model),
      controls_(controls),
      width_(model.control_count()),
      least_squared_(std::pow(threshold * float(fb_diagonal(model.get())), 2.0f)),
      rest_(4 * std::size_t(model.vertex_count())),
      positions_(rest_.size()) {
  for (std::size_t v = 0; v < model.vertex_count(); ++v)
    std::copy_n(model.rest_positions() + 3 * v, 3, rest_.begin() + std::ptrdiff_t(4 * v));
  add_ends();
  for (const Pair& pair : pairs_by_use()) add_corrective(pair);
}

void SparseShapes::add_ends() {
  for (std::size_t c = 0; c < width_; ++c) {
    const fb_control control = model_.control(static_cast<std::uint32_t>(c));
    for (const float value : {control.minimum, control.maximum}) {
      if (value == control.rest) continue;
      ends_.push_back({c, control.rest, value, shape_of(displacements(std::array{std::pair(c, value)}))});
    }
  }
  weights_.resize(ends_.size());
}

// Pairs of ends that are off rest together in any pose, those first that are in most.
std::vector<SparseShapes::Pair> SparseShapes::pairs_by_use() const {
  std::vector<std::uint32_t> uses(ends_.size() * ends_.size());
  for (std::size_t pose = 0; pose < controls_.size() / width_; ++pose) {
    std::vector<std::size_t> active;
    for (std::size_t e = 0; e < ends_.size(); ++e)
      if (ends_[e].weight(controls_[pose * width_ + ends_[e].control]) > 0) active.push_back(e);
    for (std::size_t a = 0; a < active.size(); ++a)
      for (std::size_t b = a + 1; b < active.size(); ++b) ++uses[active[a] * ends_.size() + active[b]];
  }
  std::vector<Pair> pairs;
  for (std::size_t first = 0; first < ends_.size(); ++first)
    for (std::size_t second = first + 1; second < ends_.size(); ++second)
      if (uses[first * ends_.size() + second] > 0) pairs.emplace_back(first, second);
  std::stable_sort(pairs.begin(), pairs.end(), [&](const Pair& a, const Pair& b) {
    return uses[a.first * ends_.size() + a.second] > uses[b.first * ends_.size() + b.second];
  });
  pairs.resize(std::min(pairs.size(), most_pairs));
  return pairs;
}

// Unless the two do together what each does alone, or there are enough.
void SparseShapes::add_corrective(const Pair& pair) {
  if (correctives_.size() == most_correctives) return;
  const std::pair first(ends_[pair.first].control, ends_[pair.first].value);
  const std::pair second(ends_[pair.second].control, ends_[pair.second].value);
  std::vector<float> beyond = displacements(std::array{first, second});
  const std::vector<float> a = displacements(std::array{first}), b = displacements(std::array{second});
  for (std::size_t i = 0; i < beyond.size(); ++i) beyond[i] -= a[i] + b[i];
  Shape shape = shape_of(beyond);
  if (!shape.vertices.empty()) correctives_.push_back({pair.first, pair.second, std::move(shape)});
}

std::vector<float> SparseShapes::displacements(std::span<const std::pair<std::size_t, float>> moved) {
  std::vector<float> controls = model_.rest_controls();
  for (const auto& [control, value] : moved) controls[control] = value;
  std::vector<float> made(3 * std::size_t(model_.vertex_count()));
  scratch_.evaluate(controls.data(), made.data());
  for (std::size_t i = 0; i < made.size(); ++i) made[i] -= model_.rest_positions()[i];
  return made;
}

SparseShapes::Shape SparseShapes::shape_of(const std::vector<float>& displacements) const {
  Shape shape;
  for (std::size_t v = 0; v < displacements.size() / 3; ++v) {
    const float* d = &displacements[3 * v];
    if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < least_squared_) continue;
    shape.vertices.push_back(static_cast<std::uint32_t>(v));
    shape.deltas.insert(shape.deltas.end(), {d[0], d[1], d[2], 0});
  }
  return shape;
}

void SparseShapes::weigh(const float* controls) {
  for (std::size_t e = 0; e < ends_.size(); ++e) weights_[e] = ends_[e].weight(controls[ends_[e].control]);
}

void SparseShapes::evaluate(const float* controls) {
  weigh(controls);
  std::copy(rest_.begin(), rest_.end(), positions_.begin());
  for (std::size_t e = 0; e < ends_.size(); ++e)
    if (weights_[e] != 0) ends_[e].shape.add(weights_[e], positions_.data());
  for (const Corrective& corrective : correctives_) {
    const float weight = weights_[corrective.first] * weights_[corrective.second];
    if (weight != 0) corrective.shape.add(weight, positions_.data());
  }
}

std::size_t SparseShapes::bytes() const {
  std::size_t bytes = rest_.size() * sizeof(float);
  for (const End& end : ends_) bytes += end.shape.bytes();
  for (const Corrective& corrective : correctives_) bytes += corrective.shape.bytes();
  return bytes;
}

std::size_t SparseShapes::pose_bytes(const float* controls) {
  weigh(controls);
  std::size_t bytes = rest_.size() * sizeof(float);
  for (std::size_t e = 0; e < ends_.size(); ++e)
    if (weights_[e] != 0) bytes += ends_[e].shape.bytes();
  for (const Corrective& corrective : correctives_)
    if (weights_[corrective.first] * weights_[corrective.second] != 0) bytes += corrective.shape.bytes();
  return bytes;
}

double SparseShapes::error(std::size_t poses) {
  const std::size_t vertices = model_.vertex_count();
  std::vector<float> baked(3 * vertices);
  double sum = 0;
  for (std::size_t pose = 0; pose < poses; ++pose) {
    const float* const controls = controls_.data() + pose * width_;
    scratch_.evaluate(controls, baked.data());
    evaluate(controls);
    for (std::size_t v = 0; v < vertices; ++v)
      for (std::size_t axis = 0; axis < 3; ++axis)
        sum += std::pow(double(baked[3 * v + axis]) - double(positions_[4 * v + axis]), 2);
  }
  return std::sqrt(sum / double(poses * vertices)) / fb_diagonal(model_.get());
}

}  // namespace fb::tool
