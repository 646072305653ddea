// How much of a model a pose reads, which is what its speed comes from once the model is in a processor's caches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/pose_set.h"
#include "model/packed_model.h"

namespace fb::bake {

// Counts bytes by one rule, whatever a reader's layout is. Every pose reads the controls (12 bytes: minimum, maximum,
// rest), features (20 bytes: the fields of a Feature), the direct ones and the inputs and gates of regions (4 bytes
// each), the rest position of every vertex (12 bytes) and, where there is one, its place in the order (4 bytes).
// A region is at rest, and none of it read, while all its inputs or its gate are 0. Else are read: in its first layer
// the weights of inputs that are not 0, in the others all weights (1 byte each, 2 if wide); and of every layer's output
// scale and bias (8 bytes). In each row group are read the columns of direct features that are not 0 and of regions not
// at rest: their values (1 byte each, 2 if wide), number and scale (8 bytes). Topology is read by nobody.
class ByteCount {
 public:
  explicit ByteCount(const PackedModel& model);  // which must outlive it

  // In one pose: a number a control. Thread-safe.
  std::uint64_t touched(std::span<const float> controls) const;
  // If everything moved.
  std::uint64_t stored() const;

 private:
  const PackedModel* model_;
  std::vector<float> rest_;
  std::uint64_t always_ = 0;
  std::vector<std::uint64_t> direct_;   // a direct feature's columns
  std::vector<std::uint64_t> regions_;  // all of a region but its first layer's weights
};

struct TouchedBytes {
  double mean = 0;
  std::uint64_t p95 = 0, max = 0;   // of poses
  std::uint64_t runtime_bytes = 0;  // ByteCount::stored
  std::size_t poses = 0;            // looked at
};

// Over at most 500 of the poses, evenly spaced, whose controls are the model's; all 0 without poses, but for
// runtime_bytes.
TouchedBytes touched_bytes(const PackedModel& model, const PoseSet& poses);

}  // namespace fb::bake
