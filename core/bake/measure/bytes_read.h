// Bytes of a model that evaluating a pose reads: they determine the speed once the model is in a processor's caches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/pose_set.h"
#include "figures/error_figures.h"
#include "model/packed_model.h"

namespace fb::bake {

// Counts bytes by one rule, independent of a reader's layout. Every pose reads the controls (12 bytes: minimum,
// maximum, rest), features (20 bytes: the fields of a Feature), the indices of direct features and of the inputs and
// gates of regions (4 bytes each), the rest position of every vertex (12 bytes) and, if the model has a vertex order,
// its entry (4 bytes). A region whose inputs or gate value are all 0 is skipped. Otherwise a pose reads, in its first
// layer, the weights of inputs that are not 0; in the other layers, all weights (1 byte each, 2 if wide); and each
// layer's output scales and biases (8 bytes). In each row block it reads the columns of direct features that are not 0
// and of regions that are not skipped: values (1 byte each, 2 if wide), number and scale (8 bytes). Topology is not
// read.
class BytesReadCounter {
 public:
  explicit BytesReadCounter(const PackedModel& model);  // the model must outlive it

  // Of one pose (control_count values). Thread-safe. Fails with invalid_argument on another number of controls.
  std::uint64_t of_pose(std::span<const float> controls) const;
  // Of a pose in which no feature and no gate is 0.
  std::uint64_t total() const;

 private:
  const PackedModel* model_;
  std::uint64_t always_ = 0;
  std::vector<std::uint64_t> direct_;   // columns of each direct feature
  std::vector<std::uint64_t> regions_;  // each region without the weights of its first layer
};

// Over at most 500 of the poses, evenly spaced. Without poses all are 0 but runtime_bytes.
BytesRead bytes_read_per_pose(const PackedModel& model, const PoseSet& poses);

}  // namespace fb::bake
