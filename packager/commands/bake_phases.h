// The many stages of a bake, joined to the few phases that a user is told about, and how far the whole has come.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace fb::tool {

// Phases come one after another: a stage of an earlier phase counts to the one that goes on.
class BakePhases {
 public:
  // A stage begins. True if a phase begins with it.
  bool begin(std::string_view stage);
  // The share of the stage that is done, 0 to 1.
  void update(double share);

  // The phase that goes on; "" before the first.
  std::string name() const;
  // How much of the whole bake is done, 0 to 1, by how long bakes take in their phases; never falls.
  double done() const { return done_; }

 private:
  std::size_t phase_ = 0;
  bool begun_ = false;
  double stages_ = 0;  // of the phase, before the one that goes on
  double done_ = 0;
};

}  // namespace fb::tool
