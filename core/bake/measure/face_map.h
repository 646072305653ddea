// Where the vertices of a face lie, and which controls move them, in words for reports and warnings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "base/vector3.h"
#include "model/packed_model.h"

namespace fb::bake {

// An axis-aligned box of points.
struct PointBox {
  Vector3 low, high;
};

// What each control of an archive moves alone: the larger displacement of each vertex at both ends of its range.
class FaceMap {
 public:
  FaceMap(const PackedModel& model, const Parallel& parallel);

  // "upper left", "lower middle, at the back": where in the box the mean of these vertices lies. Left and right are the
  // face's own, which looks along +z if y is up, along -y if z is up.
  std::string place_in(const PointBox& box, std::span<const std::uint32_t> vertices) const;
  // Without the outermost twentieth at each side.
  PointBox box_of(std::span<const std::uint32_t> vertices) const;
  // Of all vertices that some control moves.
  const PointBox& moving_part() const { return moving_part_; }

  // The larger displacement of a vertex at both ends of the control's range, over D.
  float motion(std::size_t control, std::size_t vertex) const { return motion_[control * vertices_ + vertex]; }

  // The vertices that a control alone moves at least a tenth as far as the one it moves most; none if it alone moves
  // nothing.
  std::vector<std::uint32_t> moved_by(std::size_t control) const;

  // The controls that move these vertices most, the first most, of those that move them at all. What a control moves
  // elsewhere counts against it: a turn of the head moves everything.
  std::vector<std::uint32_t> movers(std::span<const std::uint32_t> vertices, std::size_t at_most) const;

  // The control group of the movers; "" where groups have no names.
  std::string group_of(std::span<const std::uint32_t> vertices) const;
  // "mouth, lower left": group_of and the place in moving_part, for one vertex; of one that carries channels their
  // names.
  std::string name_of(std::uint32_t vertex) const;

 private:
  std::vector<double> influences(std::span<const std::uint32_t> vertices) const;

  RigSchema schema_;
  std::vector<float> rest_;
  std::size_t vertices_ = 0;
  std::vector<float> motion_;           // controls x vertices, over D
  std::vector<double> squared_motion_;  // by control: over all vertices
  PointBox moving_part_;
};

}  // namespace fb::bake
