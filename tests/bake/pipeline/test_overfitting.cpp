#include "bake/pipeline/overfitting.h"

#include <doctest/doctest.h>

namespace test_overfitting {

using namespace fb;
using namespace fb::bake;

namespace {

RegionStats region(const char* name, std::size_t inputs, double energy, double training, double validation) {
  RegionStats stats;
  stats.name = name;
  stats.inputs = inputs;
  stats.poses = 1500;
  stats.energy = energy;
  stats.validation = validation;
  stats.epochs = {{0.9, 0.9}, {training, validation}};
  return stats;
}

}  // namespace

TEST_CASE("networks that leave far more of held-back poses than of trained ones overfit") {
  BakeStats stats;
  stats.regions = {region("mouth", 124, 0.75, 0.03, 0.5), region("eyes", 30, 0.25, 0.03, 0.34)};
  const auto note = overfitting_note(stats);
  REQUIRE(note);
  CHECK(note->find("leave 3 % of what they were trained on and 46 % of what was held back") != std::string::npos);
  CHECK(note->find("\"mouth\", which has 124 inputs for 1500 poses") != std::string::npos);
}

TEST_CASE("networks that leave little, or as much of trained poses, do not overfit") {
  BakeStats stats;
  stats.regions = {region("leaves little", 10, 1, 0.001, 0.04)};
  CHECK_FALSE(overfitting_note(stats));
  stats.regions = {region("learns little", 10, 1, 0.3, 0.5)};
  CHECK_FALSE(overfitting_note(stats));
  stats.regions = {region("no validation poses", 10, 1, 0.01, 0)};
  CHECK_FALSE(overfitting_note(stats));
  CHECK_FALSE(overfitting_note({}));
}

}  // namespace test_overfitting
