#include <algorithm>
#include <array>
#include <queue>
#include <tuple>

#include "bake/sampling/pose_generators.h"

namespace fb::bake {
namespace {

// Positions here are fractions of a control's range, 0 at the minimum and 1 at the maximum.
struct Interval {
  double score;
  std::size_t control;
  double low, high;
  bool operator<(const Interval& other) const {
    // The queue's top has the largest score; among equals, the first control, then the lowest position.
    return std::tuple(score, other.control, other.low) < std::tuple(other.score, control, low);
  }
};

class Excitations {
 public:
  Excitations(const RigSchema& schema, const ControlResponses& responses, std::size_t poses)
      : schema_(schema), responses_(responses), remaining_(poses), positions_(schema.control_count()) {}

  std::vector<float> make() {
    const std::size_t half = remaining_ / 2;
    add_answered();
    add_ends();
    add_jumps(half);
    const std::size_t end_poses = count() - schema_.control_count();
    if (half > end_poses) bisect(half - end_poses, [](const Interval& i) { return i.high - i.low; });
    bisect(remaining_, [this](const Interval& i) { return chord_error(i); });
    return poses();
  }

 private:
  double position_of(std::size_t control, float value) const {
    const Control& c = schema_.controls[control];
    return (double(value) - c.minimum) / (double(c.maximum) - c.minimum);
  }
  double rest_position(std::size_t control) const { return position_of(control, schema_.controls[control].rest); }

  std::size_t count() const {
    std::size_t count = 0;
    for (const auto& positions : positions_) count += positions.size();
    return count;
  }

  // What is known already.
  void add_answered() {
    for (std::size_t c = 0; c < positions_.size(); ++c)
      for (const float value : responses_.answered(c)) {
        if (remaining_ == 0) return;
        positions_[c].push_back(position_of(c, value));
        --remaining_;
      }
  }

  // Every control starts with its rest position, which needs no pose, and the ends of its range.
  void add_ends() {
    std::vector<std::size_t> order(positions_.size());
    for (std::size_t c = 0; c < order.size(); ++c) order[c] = c;
    std::stable_sort(order.begin(), order.end(),
                     [this](std::size_t a, std::size_t b) { return responses_.motion(a) > responses_.motion(b); });
    for (const std::size_t c : order) positions_[c].push_back(rest_position(c));
    for (const double end : {1.0, 0.0})
      for (const std::size_t c : order) {
        if (rest_position(c) == end || remaining_ == 0 || std::ranges::count(positions_[c], end) > 0) continue;
        positions_[c].push_back(end);
        --remaining_;
      }
    for (auto& positions : positions_) std::sort(positions.begin(), positions.end());
  }

  // Both sides of every jump, while there are more than so many poses left.
  void add_jumps(std::size_t left) {
    for (std::size_t c = 0; c < positions_.size(); ++c) {
      for (const std::array<float, 2>& jump : responses_.jumps(c))
        for (const float value : jump) {
          const double position = position_of(c, value);
          if (remaining_ <= left || std::ranges::count(positions_[c], position) > 0) continue;
          positions_[c].push_back(position);
          --remaining_;
        }
      std::sort(positions_[c].begin(), positions_[c].end());
    }
  }

  // |f''| h^2 / 8 bounds the error of a chord; f'' is known from second differences a quarter of the range apart. The
  // small term keeps straight controls evenly spread.
  double chord_error(const Interval& i) const {
    const double width = i.high - i.low, middle = 2 * (i.low + i.high);
    const std::size_t nearest = middle < 1.5 ? 0 : middle < 2.5 ? 1 : 2;
    return width * width * (2 * responses_.bend(i.control)[nearest] + 1e-5);
  }

  // Bisects the interval of the highest score, `poses` times.
  template <class Score>
  void bisect(std::size_t poses, Score score) {
    std::priority_queue<Interval> queue;
    const auto push = [&](std::size_t control, double low, double high) {
      Interval interval{0, control, low, high};
      interval.score = score(interval);
      queue.push(interval);
    };
    for (std::size_t c = 0; c < positions_.size(); ++c)
      for (std::size_t k = 0; k + 1 < positions_[c].size(); ++k) push(c, positions_[c][k], positions_[c][k + 1]);
    for (; poses > 0 && !queue.empty(); --poses, --remaining_) {
      const Interval top = queue.top();
      queue.pop();
      const double middle = (top.low + top.high) / 2;
      positions_[top.control].push_back(middle);
      push(top.control, top.low, middle);
      push(top.control, middle, top.high);
    }
    for (auto& positions : positions_) std::sort(positions.begin(), positions.end());
  }

  std::vector<float> poses() const {
    std::vector<float> all;
    for (std::size_t c = 0; c < positions_.size(); ++c) {
      const Control& control = schema_.controls[c];
      for (const double position : positions_[c]) {
        if (position == rest_position(c)) continue;
        const double value = control.minimum * (1 - position) + control.maximum * position;
        std::vector<float> pose = schema_.rest_pose();
        pose[c] = std::clamp(static_cast<float>(value), control.minimum, control.maximum);
        all.insert(all.end(), pose.begin(), pose.end());
      }
    }
    return all;
  }

  const RigSchema& schema_;
  const ControlResponses& responses_;
  std::size_t remaining_;
  std::vector<std::vector<double>> positions_;  // sorted, of each control
};

}  // namespace

std::vector<float> make_excitations(const RigSchema& schema, const ControlResponses& responses, std::size_t poses) {
  return Excitations(schema, responses, poses).make();
}

}  // namespace fb::bake
