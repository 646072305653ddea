// What an earlier version of a rig answered, as poses of the controls that it has now.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bake/rig/evaluation_cache.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Reads a cache of another set of controls. They are the same by name: a control that is new is at rest, and poses
// with a control off rest that is gone, or with one outside its range, are none of the rig's.
class EarlierEvaluations {
 public:
  // Of the rig as it was when the cache was filled. Both must outlive this.
  explicit EarlierEvaluations(EvaluationCache& cache) : cache_(cache) {}
  EarlierEvaluations(EvaluationCache& cache, const RigSchema& before, const RigSchema& now);

  std::uint64_t record_count() const { return cache_.record_count(); }
  // The values of today's controls, and the points. False if the record is damaged, or none of the rig's poses.
  bool read(std::uint64_t record, std::span<float> controls, std::span<float> points);

 private:
  struct Earlier {
    std::optional<std::size_t> place;  // among today's controls; none if it is gone
    float minimum, maximum;            // what it may be for the pose to count
  };

  EvaluationCache& cache_;
  std::vector<Earlier> earlier_;  // by control of the cache; empty where they are today's
  std::vector<float> rest_;       // of today's controls
  std::vector<float> found_;
};

}  // namespace fb::bake
