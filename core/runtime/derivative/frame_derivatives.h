#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/derivative/point_group.h"
#include "runtime/evaluation_layout.h"

namespace fb::runtime {

// Where a point is among groups.
struct PointPlace {
  std::uint32_t group, slot;
};

// Frames of sockets and of driven joints in a pose, and their derivatives by the controls.
class FrameDerivatives {
 public:
  static constexpr std::size_t frame_floats = 12;

  // Of these sockets, then of these joints.
  FrameDerivatives(const EvaluationLayout& layout, std::span<const std::uint32_t> sockets,
                   std::span<const std::uint32_t> joints, std::pmr::memory_resource& memory);

  std::size_t count() const { return sockets_.size() + joints_.size(); }
  // The vertices of the sockets, which are to be points in this order.
  template <class Add>
  void visit_vertices(const Add& add) const {
    for (const std::uint32_t socket : sockets_)
      for (const SocketFrames::Point& point : layout_.sockets.points(layout_.sockets.socket(socket))) add(point.index);
  }
  // To be called once, with the places of these points.
  void set_places(std::span<const PointPlace> places) { places_.assign(places.begin(), places.end()); }
  void mark_joints(std::span<std::uint8_t> wanted) const {
    for (const std::uint32_t joint : joints_) wanted[joint] = 1;
  }

  void find_frames(std::span<const PointGroup> groups, const JointDerivatives& joints);
  // After the frames of the same pose.
  void run(std::span<const PointGroup> groups, const JointDerivatives& joints);

  // frame_floats a frame, row after row.
  const float* frames() const { return frames_.data(); }
  // Of all numbers of frames, by a control.
  const float* by_control(std::size_t control) const { return derivatives_.data() + control * frames_.size(); }

 private:
  void run_socket(std::size_t index, std::span<const PointPlace> places, std::span<const PointGroup> groups);
  void run_joint(std::size_t index, const JointDerivatives& joints);

  const EvaluationLayout& layout_;
  std::pmr::vector<std::uint32_t> sockets_, joints_;
  std::pmr::vector<PointPlace> places_;
  std::pmr::vector<SocketFrames::Fit> fits_;
  std::pmr::vector<std::uint8_t> finite_;  // by socket
  std::pmr::vector<float> frames_, derivatives_;
};

}  // namespace fb::runtime
