#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fb::bake {

// A pose that a model is off in.
struct BadPose {
  std::vector<float> pose;
  std::uint32_t vertex = 0;
  double residual = 0;   // distance at that vertex, rig units
  bool reduced = false;  // to the fewest controls
};

// The controls that are away from rest, ascending.
std::vector<std::uint32_t> active_controls(std::span<const float> pose, std::span<const float> rest);

// Sets controls of a pose back to rest, in ever smaller chunks, while half of its residual stays at its vertex: delta
// debugging (Zeller, Hildebrandt, IEEE Trans. Softw. Eng. 28, 2002). In the end no control can be set back alone.
// Poses are evaluated outside, so that many reductions can be evaluated at once.
class PoseReduction {
 public:
  // `order`: the active controls, those to set back first before the others. `bad` and `rest` must outlive it.
  PoseReduction(BadPose& bad, std::vector<std::uint32_t> order, std::span<const float> rest);

  bool done() const { return done_ || active_.size() < 2; }
  std::uint32_t vertex() const { return bad_.vertex; }
  // The pose to evaluate next.
  void fill(std::span<float> pose) const;
  // `residual`: of that pose, at the vertex.
  void advance(double residual);

 private:
  std::size_t end() const;

  BadPose& bad_;
  std::vector<std::uint32_t> active_;
  std::span<const float> rest_;
  std::size_t chunk_, at_ = 0;
  bool changed_ = false, done_ = false;
};

}  // namespace fb::bake
