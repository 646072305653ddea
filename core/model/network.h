// The graph from controls to coefficients, in floats. core/archive/EVALUATION.md defines the evaluation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "model/activation.h"
#include "model/control_feature.h"

namespace fb {

// A function of the controls that is 0 at rest: of one control (identity, ramp, hat; see control_feature.h) or of two
// earlier features (product, minimum).
struct Feature {
  using Kind = FeatureKind;
  Kind kind = Kind::identity;
  std::uint32_t control = 0;  // identity, ramp, hat
  float scale = 1;
  float threshold = 0;                  // ramp, hat; >= 0
  float fall = 0;                       // hat; >= 0: slope of the falling side over that of the rising side
  std::uint32_t first = 0, second = 0;  // product, minimum: indices of earlier features

  // A combination of features, not a function of one control.
  bool of_features() const { return kind == Kind::product || kind == Kind::minimum; }
};

// y = activation(W x + b), plus x if `skip`.
struct DenseLayer {
  std::uint32_t inputs = 0, outputs = 0;
  Activation activation = Activation::linear;
  bool skip = false;           // residual connection; requires inputs == outputs
  std::vector<float> weights;  // outputs x inputs, row-major
  std::vector<float> bias;     // outputs
};

// Multiplies a region's coefficients by clamp(slope * (sum |f| - max |f|), 0, 1) over these features: 0 while at most
// one control is away from rest, where the sparse blendshapes alone are exact. Without features there is no gate.
struct Gate {
  std::vector<std::uint32_t> features;  // identities, their controls ascending
  float slope = 10;
};

// A region of vertices with its own network: features in, coefficients out. The output of the last layer at rest is
// subtracted, so a region's coefficients are exactly 0 at rest.
struct Region {
  std::string name;
  std::vector<std::uint32_t> features;  // its inputs, indices into Network::features
  std::vector<DenseLayer> layers;       // at least one
  Gate gate = {};
};

struct Network {
  std::vector<Feature> features;
  std::vector<std::uint32_t> direct;  // features that are coefficients themselves: those of the sparse blendshapes
  std::vector<Region> regions;

  // Coefficients are in the order of basis columns: the direct ones, then those of each region.
  std::size_t coefficient_count() const;
  std::size_t parameter_count() const;  // weights and biases
};

// Validates indices, widths and finiteness; fails with the feature, region and layer.
void check(const Network& network, std::size_t control_count);

}  // namespace fb
