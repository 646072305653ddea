// Faces as float networks in Eigen: what one would link without this project.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bench/affine.h"
#include "model/packed_model.h"

namespace fb::tool {

// The network of the paper: 8 layers of 256, relu, skips, 200 components and a dense basis; weights drawn from a seed,
// for time does not depend on them.
class PaperNetwork {
 public:
  PaperNetwork(std::size_t controls, std::size_t vertices, std::uint64_t seed = 1);
  // positions: 3 x vertices floats a pose.
  void evaluate(std::size_t poses, const float* controls, float* positions);
  std::size_t bytes() const;

  struct Layer {
    std::size_t inputs, outputs;
    std::vector<float> weights, bias;  // weights: column after column
  };
  const std::vector<Layer>& layers() const { return layers_; }

 private:
  std::vector<Layer> layers_;
  std::vector<float> x_, y_;
};

// An archive's own model in floats: all features, dense layers, and the columns of every row group. `model` must
// outlive it. For time only: what layers give at rest is not subtracted.
class FloatModel {
 public:
  explicit FloatModel(const PackedModel& model);
  void evaluate(const float* controls, float* positions);
  std::size_t bytes() const;

 private:
  const PackedModel& model_;
  std::vector<float> rest_controls_, features_, coefficients_, x_, y_, rows_;
  std::vector<std::vector<std::vector<float>>> layers_;  // weights of each region's layers, column after column
  std::vector<std::vector<float>> groups_;
};

}  // namespace fb::tool
