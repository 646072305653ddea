// The explicit graph from controls to coefficients; see core/archive/FORMAT.md for what a reader must compute.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fb {

// A number computed from the controls that is 0 at rest. With u = (control - rest) * scale:
struct Feature {
  enum class Kind : std::uint32_t {
    identity = 0,  // u
    ramp = 1,      // max(u - threshold, 0); a negative scale makes the ramp of the other side
  };
  Kind kind = Kind::identity;
  std::uint32_t control = 0;
  float scale = 1;
  float threshold = 0;  // ramp only, >= 0
};

enum class Activation : std::uint32_t { linear = 0, relu = 1 };

// y = activation(W x + b), plus x where `skip`.
struct DenseLayer {
  std::uint32_t inputs = 0, outputs = 0;
  Activation activation = Activation::linear;
  bool skip = false;           // needs inputs == outputs
  std::vector<float> weights;  // outputs x inputs, row after row
  std::vector<float> bias;     // outputs
};

// A network of its own: some features in, coefficients out. What its last layer gives in the rest pose is subtracted,
// so a region's coefficients are exactly 0 at rest.
struct Region {
  std::string name;
  std::vector<std::uint32_t> features;  // its inputs, indices into Network::features
  std::vector<DenseLayer> layers;       // at least one
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
