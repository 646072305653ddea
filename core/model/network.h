// The explicit graph from controls to coefficients; see core/archive/FORMAT.md for what a reader must compute.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "model/activation.h"
#include "model/control_feature.h"

namespace fb {

// A number computed from the controls that is 0 at rest. With u = (control - rest) * scale of the control it names (see
// control_feature.h):
struct Feature {
  using Kind = FeatureKind;
  Kind kind = Kind::identity;
  std::uint32_t control = 0;  // identity, ramp, hat
  float scale = 1;
  float threshold = 0;                  // ramp, hat; >= 0
  float fall = 0;                       // hat; >= 0: how much steeper it falls than it rises
  std::uint32_t first = 0, second = 0;  // product, minimum: features that come before this one

  bool of_features() const { return kind == Kind::product || kind == Kind::minimum; }
};

// y = activation(W x + b), plus x where `skip`.
struct DenseLayer {
  std::uint32_t inputs = 0, outputs = 0;
  Activation activation = Activation::linear;
  bool skip = false;           // needs inputs == outputs
  std::vector<float> weights;  // outputs x inputs, row after row
  std::vector<float> bias;     // outputs
};

// What keeps a region still while at most one control is away from rest, where the base alone is exact: coefficients
// are multiplied by clamp(slope * (sum |f| - max |f|), 0, 1) over these features. Without features there is no gate.
struct Gate {
  std::vector<std::uint32_t> features;  // identities, their controls ascending
  float slope = 10;
};

// A network of its own: some features in, coefficients out. What its last layer gives in the rest pose is subtracted,
// so a region's coefficients are exactly 0 at rest.
struct Region {
  std::string name;
  std::vector<std::uint32_t> features;  // its inputs, indices into Network::features
  std::vector<DenseLayer> layers;       // at least one
  Gate gate = {};
};

struct Network {
  std::vector<Feature> features;
  std::vector<std::uint32_t> direct;  // features that are coefficients as they are: the base, exact on single controls
  std::vector<Region> regions;

  // Coefficients in the order of basis columns: the direct ones, then each region's.
  std::size_t coefficient_count() const;
  std::size_t parameter_count() const;
};

// Fails, naming feature, region and layer, unless every index and width fits and every number is finite.
void check(const Network& network, std::size_t control_count);

}  // namespace fb
