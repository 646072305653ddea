// Small face models for tests, made of nothing but a seed.
#pragma once

#include <cstdint>

#include "base/random.h"
#include "model/face_model.h"

namespace fb {

// A grid of columns x rows vertices in the xy plane with bumps along z, in quads.
inline Mesh grid_mesh(std::uint32_t columns, std::uint32_t rows, std::uint64_t seed = 1) {
  Random random(seed);
  Mesh mesh;
  for (std::uint32_t y = 0; y < rows; ++y)
    for (std::uint32_t x = 0; x < columns; ++x)
      mesh.points.insert(mesh.points.end(), {float(x) + 0.1f * random.uniform(), float(y), random.uniform()});
  for (std::uint32_t y = 0; y + 1 < rows; ++y)
    for (std::uint32_t x = 0; x + 1 < columns; ++x) {
      const std::uint32_t corner = y * columns + x;
      mesh.polygon_sizes.push_back(4);
      mesh.polygon_corners.insert(mesh.polygon_corners.end(),
                                  {corner, corner + 1, corner + 1 + columns, corner + columns});
    }
  return mesh;
}

inline std::vector<float> random_values(Random& random, std::size_t count, float reach) {
  std::vector<float> values(count);
  for (float& value : values) value = random.uniform(-reach, reach);
  return values;
}

inline DenseLayer random_layer(Random& random, std::uint32_t inputs, std::uint32_t outputs, Activation activation,
                               bool skip) {
  return {inputs,
          outputs,
          activation,
          skip,
          random_values(random, std::size_t(inputs) * outputs, 0.5f),
          random_values(random, outputs, 0.25f)};
}

// 5 controls, one from -1 to 1 and one at 0.25 in the rest pose; 30 vertices in quads and one triangle and one
// pentagon; identity and ramp features, 2 direct coefficients, one region of 3 layers with skip and relu that gives 3
// coefficients; a basis of two row groups with different columns.
inline FaceModel tiny_model(std::uint64_t seed = 1) {
  Random random(seed);
  FaceModel model;
  model.schema.name = "tiny";
  model.schema.controls = {{"jaw_open", 0, 1, 0, "mouth"},
                           {"mouth_side", -1, 1, 0, "mouth"},
                           {"brow_raise", 0, 1, 0.25f, "brow"},
                           {"lid_close", 0, 2, 0, "eye"},
                           {"nose_wrinkle", -0.5f, 1, 0, ""}};
  model.rest = grid_mesh(6, 5, seed);
  // The last quad becomes a triangle, and a pentagon joins it across the grid.
  model.rest.polygon_sizes.back() = 3;
  model.rest.polygon_corners.pop_back();
  model.rest.polygon_sizes.push_back(5);
  model.rest.polygon_corners.insert(model.rest.polygon_corners.end(), {29, 28, 22, 16, 17});

  using Kind = Feature::Kind;
  model.network.features = {{Kind::identity, 0, 1, 0},    {Kind::identity, 1, 1, 0},    {Kind::ramp, 1, -1, 0},
                            {Kind::ramp, 2, 1.5f, 0.25f}, {Kind::identity, 3, 0.5f, 0}, {Kind::identity, 4, 1, 0}};
  model.network.direct = {0, 3};
  model.network.regions = {
      {"face",
       {0, 1, 2, 3, 4, 5},
       {random_layer(random, 6, 8, Activation::relu, false), random_layer(random, 8, 8, Activation::relu, true),
        random_layer(random, 8, 3, Activation::linear, false)}}};
  const auto rows = static_cast<std::uint32_t>(model.rest.points.size());
  std::vector<float> dense = random_values(random, std::size_t(5) * rows, 0.5f);
  for (std::uint32_t row = 0; row < basis_group_rows; ++row) dense[1 * rows + row] = 0;     // not in the first group
  for (std::uint32_t row = basis_group_rows; row < rows; ++row) dense[4 * rows + row] = 0;  // not in the second
  model.basis = make_basis(rows, 5, dense);
  model.provenance = R"({"recipe":"tiny"})";
  return model;
}

// A pose within the controls' ranges.
inline std::vector<float> random_pose(const RigSchema& schema, Random& random) {
  std::vector<float> pose;
  for (const Control& control : schema.controls) pose.push_back(random.uniform(control.minimum, control.maximum));
  return pose;
}

}  // namespace fb
