#include "bake/analysis/holdout_set.h"

#include <doctest/doctest.h>

namespace test_holdout_set {

using namespace fb;
using namespace fb::bake;

namespace {

// Moves one vertex along x by the control times `far`.
SparseBlendshapes part_at(std::uint32_t vertex, float far) {
  return {{{Feature::Kind::identity, 0}}, {{0, {vertex}, {far, 0, 0}}}};
}

}  // namespace

TEST_CASE("parts are judged by the vertices that residuals are of") {
  // Control 0 moves vertices 0 and 2 of four by 1, in two poses.
  const std::vector<float> controls = {1, 0.5f},
                           whole = {1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0};
  const std::vector<float> judged = {1, 0, 0, 1, 0, 0, 0.5f, 0, 0, 0.5f, 0, 0};
  HoldoutSet all(controls, whole, {0}, {}), some(controls, judged, {0}, {}, {0, 2});
  const SparseBlendshapes right = part_at(0, 1), elsewhere = part_at(1, 1), wrong = part_at(2, -1);
  for (HoldoutSet* set : {&all, &some})
    for (const SparseBlendshapes* part : {&right, &elsewhere, &wrong}) set->add(*part, 1);
  CHECK(all.error().max == doctest::Approx(2));
  CHECK(some.error().max == doctest::Approx(2));
  const SparseBlendshapes* const parts[] = {&right, &elsewhere, &wrong};
  CHECK(all.prune(parts) == std::vector<bool>{true, false, false});
  CHECK(some.prune(parts) == std::vector<bool>{true, true, false});
  CHECK(some.error().max == doctest::Approx(1));
  CHECK(some.increase_without(right) == doctest::Approx(1.25));
}

}  // namespace test_holdout_set
