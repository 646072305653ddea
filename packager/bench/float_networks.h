// Faces as float networks in Eigen: what a host would link without this project.
#pragma once

#include <cstddef>
#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <vector>

#include "bench/affine.h"

namespace fb::tool {

// The network of the paper: 8 layers of 256 with relu and skips, 200 components and a dense basis. Its weights are
// random, because its time does not depend on them.
class PaperNetwork {
 public:
  PaperNetwork(std::size_t controls, std::size_t vertices, std::uint64_t seed = 1);
  // positions: 3 x vertices floats a pose.
  void evaluate(std::size_t poses, const float* controls, float* positions);
  std::size_t bytes() const;

  struct Layer {
    std::size_t inputs, outputs;
    std::vector<float> weights, bias;  // weights: column-major, outputs rows
  };
  const std::vector<Layer>& layers() const { return layers_; }

 private:
  std::vector<Layer> layers_;
  std::vector<float> x_, y_;
};

// An archive's own model in floats: all features, dense layers, and all columns of every row block. For timing only:
// what networks give at rest is not subtracted.
class FloatModel {
 public:
  // Both must outlive it.
  FloatModel(const facebaker::Archive& archive, const facebaker::Model& model);
  void evaluate(const float* controls, float* positions);
  std::size_t bytes() const;

 private:
  struct Layer {
    fb_layer shape;
    std::vector<float> weights, bias;  // weights: column-major, outputs rows
  };
  struct Region {
    std::vector<std::uint32_t> inputs;  // indices of features
    std::vector<Layer> layers;
  };
  struct RowBlock {
    std::uint32_t first_row, row_count;
    std::vector<std::uint32_t> columns;
    std::vector<float> values;  // column-major, row_count rows
  };
  Region read_region(std::uint32_t index) const;
  Layer read_layer(std::uint32_t region, std::uint32_t index) const;
  RowBlock read_row_block(std::uint32_t index) const;
  // Runs the region's network on features_; gives the end of the coefficients that it wrote.
  float* run_region(const Region& region, float* coefficients);

  const facebaker::Archive& archive_;
  const facebaker::Model& model_;
  std::vector<std::uint32_t> direct_;  // indices of the features that are coefficients
  std::vector<Region> regions_;
  std::vector<RowBlock> row_blocks_;
  std::vector<float> features_, coefficients_, x_, y_, rows_;
};

}  // namespace fb::tool
