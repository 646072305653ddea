// The many stages of a bake, joined to the few phases that a user is told about, and how far the whole has come.
#pragma once

#include <string>

#include "base/progress.h"

namespace fb::tool {

// Phases come one after another: a stage of an earlier phase counts to the one that goes on.
class BakePhases {
 public:
  // A stage of a phase begins. True if the phase begins with it.
  bool begin(Phase phase);
  // The share of the stage that is done, 0 to 1.
  void update(double share);

  // What the phase that goes on is called; "" before the first.
  std::string name() const;
  Phase phase() const { return phase_; }
  // How much of the whole bake is done, 0 to 1, by how long bakes take in their phases; never falls.
  double done() const { return done_; }

 private:
  Phase phase_ = Phase::sampling;
  bool begun_ = false;
  double stages_ = 0;  // of the phase, before the one that goes on
  double done_ = 0;
};

}  // namespace fb::tool
