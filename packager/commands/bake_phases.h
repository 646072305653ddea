// The many stages of a bake, joined to the few phases that a user is told about, how far the whole has come, and how
// long the rest takes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/progress.h"

namespace fb::tool {

// Phases come one after another: a stage of an earlier phase counts to the one that goes on.
class BakePhases {
 public:
  // draws: whether pictures are drawn at the end, for a report.
  explicit BakePhases(bool draws) : draws_(draws) {}

  // A stage of a phase begins. True if the phase begins with it.
  bool begin(Phase phase, std::string_view stage);
  // The share of the stage that is done, 0 to 1.
  void update(double share);
  // How long the rest of the bake takes, in seconds, if the stage that goes on takes `stage_left` more after `gone` of
  // all: phases to come are taken for the share of the whole that they usually are. Nothing before the networks' own
  // training, nor of a bake without: bakes differ too much in how long what comes then takes. done() follows it.
  std::optional<double> seconds_left(double stage_left, double gone);

  // What the phase that goes on is called; "" before the first.
  std::string name() const;
  // How much of the whole bake is done, 0 to 1, by how long bakes take in their phases; never falls.
  double done() const { return done_; }

 private:
  double share_after(Phase phase) const;

  bool draws_;
  Phase phase_ = Phase::sampling;
  bool begun_ = false, trains_ = false;  // from the networks' own training on
  double stages_ = 0;                    // of the phase, before the one that goes on
  double done_ = 0;
};

}  // namespace fb::tool
