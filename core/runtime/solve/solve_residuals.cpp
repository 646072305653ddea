#include "runtime/solve/solve_residuals.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fb::runtime {
namespace {

std::size_t up_to_vectors(std::size_t count) {
  return (count + padding - 1) / padding * padding;
}

constexpr std::size_t frame_floats = FrameDerivatives::frame_floats;

float arm_length(const Evaluator& evaluator) {
  const std::span<const float> points = evaluator.rest_positions();
  double squares = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float least = points[axis], most = least;
    for (std::size_t i = axis; i < points.size(); i += 3) {
      least = std::min(least, points[i]);
      most = std::max(most, points[i]);
    }
    squares += (double(most) - least) * (double(most) - least);
  }
  return static_cast<float>(0.25 * std::sqrt(squares));
}

}  // namespace

SolveResiduals::SolveResiduals(const Evaluator& evaluator, const Followed& followed, std::span<const PointPair> pairs,
                               std::pmr::memory_resource& memory)
    : kernels_(evaluator.kernels()),
      pose_(evaluator, followed, memory),
      lengths_(evaluator.control_count(), &memory),
      point_count_(followed.points.size()),
      arm_(arm_length(evaluator)),
      pairs_(pairs.begin(), pairs.end(), &memory),
      rows_(&memory),
      given_(3 * followed.points.size(), &memory),
      given_frames_(frame_floats * pose_.frames().count(), &memory),
      all_controls_(evaluator.control_count(), &memory),
      extra_values_(up_to_vectors(pairs.size() + given_frames_.size()), &memory),
      by_control_(extra_values_.size() * evaluator.control_count(), &memory),
      gathered_(&memory),
      by_row_(&memory),
      sums_(padding * up_to_vectors(evaluator.control_count() + motion_unknowns), &memory),
      unknown_places_(evaluator.control_count() + motion_unknowns, &memory) {
  for (std::size_t c = 0; c < lengths_.size(); ++c)
    lengths_[c] = evaluator.schema().controls[c].maximum - evaluator.schema().controls[c].minimum;
  std::iota(all_controls_.begin(), all_controls_.end(), 0u);
  rows_.reserve(pose_.groups().size() + 1);
  std::size_t longest = extra_values_.size(), most = 0;
  for (const PointGroup& group : pose_.groups()) {
    rows_.emplace_back(group.length(), memory);
    longest = std::max(longest, group.length());
    most = std::max(most, group.controls().size());
  }
  rows_.emplace_back(extra_values_.size(), memory);
  if (!extra_values_.empty()) most = lengths_.size();
  gathered_.resize(longest * (most + motion_unknowns));
  by_row_.resize(longest * up_to_vectors(most + motion_unknowns));
}

float SolveResiduals::weight(std::size_t point) const {
  return rows_[pose_.place(point).group].scales[pose_.place(point).slot];
}

void SolveResiduals::set_targets(const SolveTargets& targets, double noise) {
  const auto scale_of = [&](const float* values, const float* weights, std::size_t index) {
    if (!values) return 0.0f;
    return static_cast<float>((weights ? std::sqrt(static_cast<double>(weights[index])) : 1.0) / noise);
  };
  for (std::size_t p = 0; p < point_count_; ++p) {
    const auto [group, slot] = pose_.place(p);
    const float scale = scale_of(targets.points, targets.point_weights, p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rows_[group].scales[axis * pose_.groups()[group].stride() + slot] = scale;
      given_[3 * p + axis] = scale > 0 ? targets.points[3 * p + axis] : 0;
    }
  }
  Rows& extra = rows_.back();
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    extra.scales[k] = scale_of(targets.distances, targets.distance_weights, k);
    extra.targets[k] = extra.scales[k] > 0 ? targets.distances[k] : 0;
  }
  for (std::size_t i = 0; i < given_frames_.size(); ++i) {
    const float scale = scale_of(targets.frames, targets.frame_weights, i / frame_floats);
    extra.scales[pairs_.size() + i] = i % 4 == 3 ? scale : scale * arm_;
    given_frames_[i] = scale > 0 ? targets.frames[i] : 0;
  }
  for (Rows& rows : rows_) {
    rows.counting.clear();
    for (std::uint32_t i = 0; i < rows.scales.size(); ++i)
      if (rows.scales[i] > 0) rows.counting.push_back(i);
  }
  set_motion({});
}

// In the space of the face a target lies at y = R^T (given - translation), and a direction at R^T given. A small
// rotation about w and a translation v before the motion move it by -w x y - v, and a direction by -w x y.
void SolveResiduals::place_vector(Rows& rows, const RigidMotion& motion, const float* given, const std::size_t (&at)[3],
                                  bool direction) const {
  const std::array<double, 9> r = motion.matrix();
  double from[3], y[3];
  for (std::size_t a = 0; a < 3; ++a) from[a] = given[a] - (direction ? 0 : motion.translation[a]);
  for (std::size_t a = 0; a < 3; ++a) {
    y[a] = r[a] * from[0] + r[3 + a] * from[1] + r[6 + a] * from[2];
    rows.targets[at[a]] = static_cast<float>(y[a]);
  }
  const std::size_t length = rows.targets.size();
  for (std::size_t a = 0; a < 3; ++a) {  // of w along axis a, w x y; of v along it, 1
    rows.motion[a * length + at[(a + 1) % 3]] = static_cast<float>(-y[(a + 2) % 3]);
    rows.motion[a * length + at[(a + 2) % 3]] = static_cast<float>(y[(a + 1) % 3]);
    rows.motion[(3 + a) * length + at[a]] = direction ? 0.0f : 1.0f;
  }
}

void SolveResiduals::set_motion(const RigidMotion& motion) {
  for (std::size_t p = 0; p < point_count_; ++p) {
    const auto [group, slot] = pose_.place(p);
    const std::size_t stride = pose_.groups()[group].stride();
    place_vector(rows_[group], motion, &given_[3 * p], {slot, stride + slot, 2 * stride + slot}, false);
  }
  for (std::size_t i = 0; i < given_frames_.size(); i += frame_floats)
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t first = pairs_.size() + i + c;
      const float given[3] = {given_frames_[i + c], given_frames_[i + 4 + c], given_frames_[i + 8 + c]};
      place_vector(rows_.back(), motion, given, {first, first + 4, first + 8}, c < 3);
    }
}

double SolveResiduals::half_of_squares(Rows& rows, const float* values) const {
  for (std::size_t i = 0; i < rows.residuals.size(); ++i) {
    rows.residuals[i] = rows.scales[i] * (values[i] - rows.targets[i]);
    rows.pulls[i] = rows.scales[i] * rows.residuals[i];
  }
  float sum = 0;
  kernels_.dot_products(rows.residuals.data(), rows.residuals.data(), 0, 1, rows.residuals.size(), &sum);
  return 0.5 * sum;
}

std::array<float, 3> SolveResiduals::difference(std::size_t point) const {
  if (!counts(point)) return {};
  const auto [group, slot] = pose_.place(point);
  std::array<float, 3> difference = pose_.position(point);
  for (std::size_t axis = 0; axis < 3; ++axis)
    difference[axis] -= rows_[group].targets[axis * pose_.groups()[group].stride() + slot];
  return difference;
}

void SolveResiduals::find_extra_values() {
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const std::array<float, 3> a = pose_.position(pairs_[k].first), b = pose_.position(pairs_[k].second);
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    extra_values_[k] = std::sqrt((x * x + y * y) + z * z);
  }
  std::copy_n(pose_.frames().frames(), given_frames_.size(), extra_values_.begin() + std::ptrdiff_t(pairs_.size()));
}

// The derivative of a distance is that of the difference of its points along it.
void SolveResiduals::find_extra_derivatives() {
  const std::size_t length = extra_values_.size();
  std::fill(by_control_.begin(), by_control_.end(), 0.0f);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    if (extra_values_[k] == 0) continue;
    const std::array<float, 3> a = pose_.position(pairs_[k].first), b = pose_.position(pairs_[k].second);
    for (const auto& [point, sign] : {std::pair(pairs_[k].first, 1.0f), std::pair(pairs_[k].second, -1.0f)}) {
      const PointGroup& group = pose_.groups()[pose_.place(point).group];
      const std::size_t stride = group.stride(), slot = pose_.place(point).slot;
      float along[3];
      for (std::size_t axis = 0; axis < 3; ++axis) along[axis] = sign * (a[axis] - b[axis]) / extra_values_[k];
      for (std::size_t c = 0; c < group.controls().size(); ++c) {
        const float* const of = group.by_control(c) + slot;
        by_control_[group.controls()[c] * length + k] +=
            (along[0] * of[0] + along[1] * of[stride]) + along[2] * of[2 * stride];
      }
    }
  }
  for (std::size_t c = 0; c < lengths_.size() && !given_frames_.empty(); ++c)
    std::copy_n(pose_.frames().by_control(c), given_frames_.size(), &by_control_[c * length + pairs_.size()]);
}

double SolveResiduals::half_of_squares() {
  double sum = 0;
  for (std::size_t g = 0; g < pose_.groups().size(); ++g)
    sum += half_of_squares(rows_[g], pose_.groups()[g].positions());
  if (extra_values_.empty()) return sum;
  find_extra_values();
  return sum + half_of_squares(rows_.back(), extra_values_.data());
}

double SolveResiduals::find(const float* controls) {
  pose_.find_positions(controls);
  return half_of_squares();
}

double SolveResiduals::run(const float* controls, const std::uint8_t* downwards) {
  pose_.run(controls, downwards);
  const double sum = half_of_squares();
  find_extra_derivatives();
  return sum;
}

void SolveResiduals::add_gradient(bool motion, float* gradient) const {
  float sums[motion_unknowns];
  const auto add = [&](const Rows& rows, std::span<const std::uint32_t> controls, const float* first) {
    for (std::size_t c = 0; c < controls.size(); c += motion_unknowns) {
      const std::size_t count = std::min(controls.size() - c, motion_unknowns), length = rows.pulls.size();
      kernels_.dot_products(rows.pulls.data(), first + c * length, length, count, length, sums);
      for (std::size_t i = 0; i < count; ++i) gradient[controls[c + i]] += lengths_[controls[c + i]] * sums[i];
    }
  };
  for (std::size_t g = 0; g < pose_.groups().size(); ++g) {
    const PointGroup& group = pose_.groups()[g];
    if (group.controls().empty()) continue;
    add(rows_[g], group.controls(), group.by_control(0));
  }
  if (!extra_values_.empty()) add(rows_.back(), all_controls_, by_control_.data());
  for (std::size_t g = 0; g < rows_.size() && motion; ++g) {
    const std::size_t length = rows_[g].pulls.size();
    if (length == 0) continue;
    kernels_.dot_products(rows_[g].pulls.data(), rows_[g].motion.data(), length, motion_unknowns, length, sums);
    for (std::size_t i = 0; i < motion_unknowns; ++i) gradient[lengths_.size() + i] += sums[i];
  }
}

// first: derivatives by each of `controls`. Gathers those of unknowns in the rows that count, scaled, and multiplies
// them by each other.
void SolveResiduals::add_products_of(const Rows& rows, std::span<const std::uint32_t> controls, const float* first,
                                     std::span<const std::uint32_t> unknowns, float* matrix, std::size_t stride) {
  const std::size_t length = rows.scales.size();
  const std::size_t used = rows.counting.size();
  std::size_t count = 0;
  const auto gather = [&](const float* from, float factor, std::uint32_t place) {
    float* const to = gathered_.data() + count * used;
    for (std::size_t i = 0; i < used; ++i) to[i] = factor * (rows.scales[rows.counting[i]] * from[rows.counting[i]]);
    unknown_places_[count++] = place;
  };
  std::size_t c = 0;
  for (std::uint32_t u = 0; u < unknowns.size(); ++u) {
    if (unknowns[u] >= lengths_.size()) {
      gather(rows.motion.data() + (unknowns[u] - lengths_.size()) * length, 1, u);
      continue;
    }
    while (c < controls.size() && controls[c] < unknowns[u]) ++c;
    if (c < controls.size() && controls[c] == unknowns[u]) gather(first + c * length, lengths_[unknowns[u]], u);
  }
  const std::size_t width = up_to_vectors(count);
  for (std::size_t i = 0; i < used; ++i) {
    float* const to = by_row_.data() + i * width;
    for (std::size_t u = 0; u < count; ++u) to[u] = gathered_[u * used + i];
    std::fill(to + count, to + width, 0.0f);
  }
  for (std::size_t i = 0; i < count; i += padding) {  // as many rows of products at a time, up to the diagonal
    const std::size_t some = std::min(padding, count - i);
    std::fill_n(sums_.begin(), some * width, 0.0f);
    kernels_.add_products({sums_.data(), width, some}, {gathered_.data() + i * used, used, some}, by_row_.data(), width,
                          used, up_to_vectors(i + some));
    for (std::size_t k = i; k < i + some; ++k) {
      float* const row = matrix + unknown_places_[k] * stride;
      const float* const sums = sums_.data() + (k - i) * width;
      for (std::size_t j = 0; j <= k; ++j) row[unknown_places_[j]] += sums[j];
    }
  }
}

void SolveResiduals::add_products(std::span<const std::uint32_t> unknowns, float* matrix, std::size_t stride) {
  for (std::size_t g = 0; g < pose_.groups().size(); ++g) {
    const PointGroup& group = pose_.groups()[g];
    const float* const first = group.controls().empty() ? nullptr : group.by_control(0);
    add_products_of(rows_[g], group.controls(), first, unknowns, matrix, stride);
  }
  if (!extra_values_.empty())
    add_products_of(rows_.back(), all_controls_, by_control_.data(), unknowns, matrix, stride);
}

}  // namespace fb::runtime
