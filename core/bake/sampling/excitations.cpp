#include <algorithm>
#include <queue>
#include <tuple>

#include "bake/sampling/pose_generators.h"

namespace fb::bake {
namespace {

// Positions are shares of a control's range, 0 at the minimum and 1 at the maximum.
struct Interval {
  double score;
  std::size_t control;
  double low, high;
  bool operator<(const Interval& other) const {
    // The queue's top is the largest score; ties go to the first control, then the lowest position.
    return std::tuple(score, other.control, other.low) < std::tuple(other.score, control, low);
  }
};

class Excitations {
 public:
  Excitations(const RigSchema& schema, const ControlResponses& responses, std::size_t poses)
      : schema_(schema), probe_(responses), left_(poses), positions_(schema.control_count()) {}

  std::vector<float> make() {
    const std::size_t half = left_ / 2;
    add_ends();
    const std::size_t spent_on_ends = count() - schema_.control_count();
    if (half > spent_on_ends) split(half - spent_on_ends, [](const Interval& i) { return i.high - i.low; });
    split(left_, [this](const Interval& i) { return missed_by_a_line(i); });
    return poses();
  }

 private:
  double rest_position(std::size_t control) const {
    const Control& c = schema_.controls[control];
    return (double(c.rest) - c.minimum) / (double(c.maximum) - c.minimum);
  }

  std::size_t count() const {
    std::size_t count = 0;
    for (const auto& positions : positions_) count += positions.size();
    return count;
  }

  // Every control starts with its rest position, which costs no pose, and the ends of its range.
  void add_ends() {
    std::vector<std::size_t> order(positions_.size());
    for (std::size_t c = 0; c < order.size(); ++c) order[c] = c;
    std::stable_sort(order.begin(), order.end(),
                     [this](std::size_t a, std::size_t b) { return probe_.motion(a) > probe_.motion(b); });
    for (const std::size_t c : order) positions_[c].push_back(rest_position(c));
    for (const double end : {1.0, 0.0})
      for (const std::size_t c : order) {
        if (rest_position(c) == end || left_ == 0) continue;
        positions_[c].push_back(end);
        --left_;
      }
    for (auto& positions : positions_) std::sort(positions.begin(), positions.end());
  }

  // |f''| h^2 / 8 bounds the error of a chord; f'' is known from second differences a quarter of the range apart. The
  // small term keeps straight controls evenly spread.
  double missed_by_a_line(const Interval& i) const {
    const double width = i.high - i.low, middle = 2 * (i.low + i.high);
    const std::size_t nearest = middle < 1.5 ? 0 : middle < 2.5 ? 1 : 2;
    return width * width * (2 * probe_.bend(i.control)[nearest] + 1e-5);
  }

  // Halves the interval of the highest score, `poses` times.
  template <class Score>
  void split(std::size_t poses, Score score) {
    std::priority_queue<Interval> queue;
    const auto push = [&](std::size_t control, double low, double high) {
      Interval interval{0, control, low, high};
      interval.score = score(interval);
      queue.push(interval);
    };
    for (std::size_t c = 0; c < positions_.size(); ++c)
      for (std::size_t k = 0; k + 1 < positions_[c].size(); ++k) push(c, positions_[c][k], positions_[c][k + 1]);
    for (; poses > 0 && !queue.empty(); --poses, --left_) {
      const Interval widest = queue.top();
      queue.pop();
      const double middle = (widest.low + widest.high) / 2;
      positions_[widest.control].push_back(middle);
      push(widest.control, widest.low, middle);
      push(widest.control, middle, widest.high);
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
  const ControlResponses& probe_;
  std::size_t left_;
  std::vector<std::vector<double>> positions_;  // sorted, of each control
};

}  // namespace

std::vector<float> make_excitations(const RigSchema& schema, const ControlResponses& responses, std::size_t poses) {
  return Excitations(schema, responses, poses).make();
}

}  // namespace fb::bake
