// Small face models for tests, made of nothing but a seed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "base/random.h"
#include "model/face_model.h"
#include "model/packed_model.h"

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

// A closed surface of two handles with holes, in quads and triangles: a grid whose ends meet, with a tunnel, flipped
// polygons, a triangle and its back, three triangles on an edge, two fans on one vertex, and two vertices of no
// polygon.
inline Mesh odd_surface(std::uint32_t columns, std::uint32_t rows, std::uint64_t seed = 1) {
  Mesh mesh = grid_mesh(columns, rows, seed);
  mesh.polygon_sizes.clear();
  mesh.polygon_corners.clear();
  const auto add = [&](std::vector<std::uint32_t> corners) {
    mesh.polygon_sizes.push_back(static_cast<std::uint32_t>(corners.size()));
    mesh.polygon_corners.insert(mesh.polygon_corners.end(), corners.begin(), corners.end());
  };
  for (std::uint32_t y = 0; y < rows; ++y)
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t right = (x + 1) % columns, up = (y + 1) % rows;
      if ((x == 1 && y == 1) || (x == columns - 2 && y == rows - 2)) continue;
      const std::uint32_t a = y * columns + x, b = y * columns + right, c = up * columns + right, d = up * columns + x;
      if (x == 3 && y == 2)
        add({a, d, c, b});
      else if (x == 0)
        add({a, b, c}), add({a, c, d});
      else
        add({a, b, c, d});
    }
  const auto corner = [&](std::uint32_t x, std::uint32_t y) { return y * columns + x; };
  const std::uint32_t near[] = {corner(1, 1), corner(2, 1), corner(2, 2), corner(1, 2)},
                      far[] = {corner(columns - 2, rows - 2), corner(columns - 1, rows - 2),
                               corner(columns - 1, rows - 1), corner(columns - 2, rows - 1)};
  for (std::size_t k = 0; k < 4; ++k) add({near[k], near[(k + 1) % 4], far[(5 - k) % 4], far[(6 - k) % 4]});
  const auto first = static_cast<std::uint32_t>(mesh.vertex_count());
  for (std::uint32_t v = 0; v < 9; ++v)
    mesh.points.insert(mesh.points.end(), {float(v), -3.0f, v % 2 == 0 ? 1.0f : 2.0f});
  add({first, first + 1, first + 2});
  add({first, first + 2, first + 1});
  add({0, 1, first + 3});
  add({5, first + 4, first + 5});
  add({first + 6, first + 6, first + 5});
  return mesh;
}

// Texture coordinates for a mesh: one pair a vertex, and another for the corners of the latter half of the polygons, so
// that a seam lies between.
inline void give_uvs(Mesh& mesh) {
  const auto vertices = static_cast<std::uint32_t>(mesh.vertex_count());
  mesh.uvs.clear();
  mesh.uv_corners.clear();
  for (const float shift : {0.0f, 0.5f})
    for (std::uint32_t v = 0; v < vertices; ++v) {
      mesh.uvs.push_back(shift + 0.05f * mesh.points[3 * v]);
      mesh.uvs.push_back(0.1f * mesh.points[3 * v + 1]);
    }
  for (std::size_t c = 0; c < mesh.polygon_corners.size(); ++c)
    mesh.uv_corners.push_back(mesh.polygon_corners[c] + (2 * c < mesh.polygon_corners.size() ? 0 : vertices));
}

// One pair a vertex, as glTF has them.
inline void give_uvs_by_vertex(Mesh& mesh) {
  give_uvs(mesh);
  mesh.uvs.resize(2 * mesh.vertex_count());
  mesh.uv_corners = mesh.polygon_corners;
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
// coefficients; a basis of two row blocks with different columns.
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
  for (std::uint32_t row = 0; row < default_block_rows; ++row) dense[1 * rows + row] = 0;     // not in the first block
  for (std::uint32_t row = default_block_rows; row < rows; ++row) dense[4 * rows + row] = 0;  // not in the second
  model.basis = make_basis(rows, 5, dense);
  model.provenance = R"({"recipe":"tiny"})";
  return model;
}

// Within -reach..reach.
inline std::pmr::vector<std::int16_t> random_numbers(Random& random, std::size_t count, int reach) {
  std::pmr::vector<std::int16_t> numbers(count);
  for (std::int16_t& number : numbers)
    number = static_cast<std::int16_t>(int(random.below(static_cast<std::uint32_t>(2 * reach + 1))) - reach);
  return numbers;
}

// Weights of up to +-0.5 in all, however wide.
inline PackedLayer random_packed_layer(Random& random, std::uint32_t inputs, std::uint32_t outputs,
                                       Activation activation, bool skip, bool wide) {
  const int largest = wide ? largest_wide : largest_narrow;
  PackedLayer layer{inputs,     outputs,
                    activation, skip,
                    wide,       random_numbers(random, std::size_t(inputs) * outputs, largest),
                    {},         random_values(random, outputs, 0.25f)};
  for (std::uint32_t o = 0; o < outputs; ++o) layer.scales.push_back(random.uniform(0.25f, 0.5f) / float(largest));
  return layer;
}

// A block that uses the columns given, about every other one wide, and moves by up to `reach` each.
inline PackedRowBlock random_row_block(Random& random, std::uint32_t first_row, std::uint32_t row_count,
                                       const std::vector<std::uint32_t>& columns, float reach) {
  PackedRowBlock block{first_row, row_count, {}, {}};
  for (const std::uint32_t column : columns) {
    const bool wide = random.uniform() < 0.5f;
    const int largest = wide ? largest_wide : largest_narrow;
    block.columns.push_back({column, wide, reach / float(largest)});
    const std::pmr::vector<std::int16_t> values = random_numbers(random, row_count, largest);
    block.values.insert(block.values.end(), values.begin(), values.end());
  }
  return block;
}

// Gives every wide column other values, of which the largest is between 128 and largest_wide, that move as far.
inline void vary_wide_columns(PackedRowBlock& block, Random& random) {
  for (std::size_t c = 0; c < block.columns.size(); ++c) {
    if (!block.columns[c].wide) continue;
    const int largest = largest_wide >> random.below(8);
    block.columns[c].scale *= float(largest_wide) / float(largest);
    const std::pmr::vector<std::int16_t> values = random_numbers(random, block.row_count, largest);
    std::copy(values.begin(), values.end(), block.values.begin() + static_cast<std::ptrdiff_t>(c * block.row_count));
  }
}

// The controls, mesh and sizes of tiny_model, in whole numbers, with everything a packed model can have: features of
// every kind, narrow and wide layers, all activations, a gated region, narrow and wide columns, rows in another order.
// jaw_open is a direct coefficient; at most 1 away from rest it moves every vertex of the first rows.
inline PackedModel tiny_packed_model(std::uint64_t seed = 1) {
  const FaceModel tiny = tiny_model(seed);
  Random random(seed, 1);
  PackedModel model;
  model.schema = tiny.schema;
  model.rest = tiny.rest;
  model.provenance = tiny.provenance;
  model.features = tiny.network.features;
  using Kind = Feature::Kind;
  model.features.push_back({Kind::hat, 3, 1, 0.5f, 2});
  model.features.push_back({Kind::product, 0, 1, 0, 0, 0, 6});
  model.features.push_back({Kind::minimum, 0, 1, 0, 0, 3, 5});
  model.direct = {0, 8};
  model.regions = {{"face",
                    {0, 1, 2, 6, 7, 5},
                    {random_packed_layer(random, 6, 8, Activation::relu, false, true),
                     random_packed_layer(random, 8, 8, Activation::relu, true, false),
                     random_packed_layer(random, 8, 2, Activation::linear, false, false)},
                    {}},
                   {"brow",
                    {3, 4},
                    {random_packed_layer(random, 2, 4, Activation::tanh, false, false),
                     random_packed_layer(random, 4, 4, Activation::silu, true, true),
                     random_packed_layer(random, 4, 1, Activation::linear, false, false)},
                    {{0, 1, 4, 5}, 2}}};
  model.columns = 5;
  const auto vertices = static_cast<std::uint32_t>(model.rest.vertex_count());
  for (std::uint32_t i = 0; i < vertices; ++i) model.order.push_back((7 * i + 3) % vertices);
  model.row_blocks = {random_row_block(random, 0, 63, {0, 2, 3, 4}, 0.5f),
                      random_row_block(random, 63, 27, {0, 1, 2, 3}, 0.5f)};
  return model;
}

// One control and so many columns, which all have its value as coefficient: even ones move by little, odd ones by much.
inline PackedModel two_kinds_of_columns(std::uint32_t columns) {
  PackedModel model;
  model.schema.controls = {{"c", 0, 1, 0, ""}};
  model.rest = grid_mesh(3, 2, 1);
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.direct.assign(columns, 0);
  model.columns = columns;
  PackedRowBlock block{0, static_cast<std::uint32_t>(model.rest.points.size()), {}, {}};
  Random random(1, 1);
  for (std::uint32_t c = 0; c < columns; ++c) {
    block.columns.push_back({c, false, 0.001f});
    for (const std::int16_t value : random_numbers(random, block.row_count, c % 2 == 0 ? 1 : 100))
      block.values.push_back(value);
  }
  model.row_blocks = {block};
  return model;
}

// A PNG of one white pixel.
inline std::vector<std::byte> white_png() {
  static constexpr unsigned char bytes[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
      0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
      0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xf8, 0x0f, 0x00, 0x01, 0x01, 0x01, 0x00,
      0x1c, 0xb0, 0x8c, 0x99, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  const auto whole = std::as_bytes(std::span(bytes));
  return {whole.begin(), whole.end()};
}

// Two meshes, "head" of 3 x 6 vertices and "teeth" of 2 x 6, with texture coordinates, materials and images, moved as
// tiny_packed_model is, in three row blocks, and four channels in a fourth; with sockets, labels, a thumbnail, and
// something said about it.
inline PackedModel character_model(std::uint64_t seed = 1) {
  PackedModel model = tiny_packed_model(seed);
  model.rest = grid_mesh(6, 3, seed);
  const Mesh teeth = grid_mesh(6, 2, seed + 1);
  for (std::size_t i = 0; i < teeth.points.size(); ++i)
    model.rest.points.push_back(teeth.points[i] - (i % 3 == 2 ? 4 : 0));
  for (const std::uint32_t corner : teeth.polygon_corners) model.rest.polygon_corners.push_back(18 + corner);
  model.rest.polygon_sizes.insert(model.rest.polygon_sizes.end(), 5, 4);
  give_uvs_by_vertex(model.rest);
  model.rest.parts = {{"head", 18, 10, {{6, 0}, {4, no_material}}}, {"teeth", 12, 5, {{5, 1}}}};
  for (std::uint32_t i = 0; i < 30; ++i) model.order[i] = i < 18 ? 17 - i : 18 + (5 * i) % 12;
  Random random(seed, 2);
  model.row_blocks = {
      random_row_block(random, 0, 27, {0, 2, 3, 4}, 0.5f), random_row_block(random, 27, 27, {0, 1, 3}, 0.5f),
      random_row_block(random, 54, 36, {0, 1, 2}, 0.5f), random_row_block(random, 90, 6, {0, 2, 4}, 0.5f)};
  model.schema.channels = {{"frown", "", 0, 1, 0, 0.75f},
                           {"blush", "", 0, 1, 0.25f, 0.5f},
                           {"eye_turn", "degrees", -30, 30, 0, 50},
                           {"heat", "K", 300, 320, 310, 8}};
  model.rest.carrier_vertices = 2;
  model.rest.points.resize(96);
  model.order.insert(model.order.end(), {30, 31});
  const auto image = [](const char* name, const char* type, std::size_t size) {
    return Image{name, type, std::vector<std::byte>(size, std::byte(0x89))};
  };
  model.character.images = {image("skin", "image/png", 20), image("bumps", "image/jpeg", 7),
                            image("", "image/ktx2", 0)};
  Material skin{"skin", {0.5f, 0.25f, 0.125f, 1}, 0, 0.75f, {0, 0.5f, 0}};
  skin.alpha_mode = AlphaMode::mask;
  skin.alpha_cutoff = 0.25f;
  skin.double_sided = true;
  skin.textures = {{TextureSlot::base_colour, 0}, {TextureSlot::normal, 1, Wrap::clamp, Wrap::mirror, 0.5f}};
  model.schema.controls[0].labels = {"jawOpen", "AU26", "degrees", ""};
  model.schema.controls[2].labels.mirror = "lid_close";
  model.schema.controls[3].labels = {"eyeBlinkLeft", "", "", "brow_raise"};
  model.character.sockets = {{"nose", {1, 2, 7, 8, 13}, {1, 0.5f, 2, 1, 1}, {0, -1, 0, 2, 1, 0, 0, 1.5f, 0, 0, 1, 1}},
                             {"tooth", {29, 23, 18}, {1, 1, 1}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -4}}};
  model.expected.unit = 0.125f;
  model.expected.regions = {{"mouth", 0.25f}, {"brows, upper left", 0}};
  model.expected.runs = {{9, 0}, {12, 1}, {9, 0}};
  const std::size_t controls = model.schema.control_count();
  for (std::size_t i = 0; i < 2 * controls; ++i)
    model.expected.weights.push_back(static_cast<std::uint8_t>(i == 2 ? 0 : 180 + 7 * i));
  model.expected.trained_low.assign(controls, 10);
  model.expected.trained_high.assign(controls, 200);
  model.expected.untrained_pairs.resize(pair_bytes(controls));
  model.expected.set_untrained(0, 1);
  model.expected.set_untrained(1, 3);
  model.character.materials = {skin, {"", {1, 1, 1, 0.5f}, 1, 0, {0, 0, 0}, AlphaMode::blend}};
  model.character.about =
      "{\"author\":\"Ren\xc3\xa9"
      "e\",\"rights\":{\"learning\":\"forbidden\"},\"shelf\":7}";
  model.character.thumbnail = white_png();
  return model;
}

// character_model() baked anew from a rig in which two controls have changed places and the last one has another name;
// its materials have one name, and textures of one name.
inline PackedModel rebaked_model(std::uint64_t seed = 1) {
  PackedModel model = character_model(seed);
  std::swap(model.schema.controls[0], model.schema.controls[1]);
  model.schema.controls.back().name = "nose_flare";
  for (Material& material : model.character.materials) material.name = "skin";
  model.character.materials[1].textures = {{TextureSlot::base_colour, 1}};
  model.character.images[1].name = "skin";
  return model;
}

// character_model() with two exact poses that disturb neither each other nor the rest pose; the second corrects nothing
// in the first row block.
inline PackedModel exact_model(std::uint64_t seed = 1) {
  PackedModel model = character_model(seed);
  Random random(seed, 3);
  const RigSchema& schema = model.schema;
  const std::vector<float> rest = places_in_ranges(schema, schema.rest_pose());
  std::vector<std::vector<float>> places;
  for (const char* name : {"smile:12", "frown:0"}) {
    ExactPose& pose = model.exact.emplace_back(ExactPose{name, schema.rest_pose(), 0, 0x1p-20f});
    for (std::size_t c = 0; c < 3; ++c)
      pose.controls[c] = random.uniform(schema.controls[c].minimum, schema.controls[c].maximum);
    for (std::size_t row = 0; row < model.rest.points.size(); ++row)
      pose.values.push_back(static_cast<std::int32_t>(random.uniform(-1, 1) * 1e6f));
    places.push_back(places_in_ranges(schema, pose.controls));
  }
  std::fill_n(model.exact[1].values.begin(), model.row_blocks[0].row_count, 0);
  model.exact[0].values[40] = largest_correction;
  for (std::size_t i = 0; i < 2; ++i)
    model.exact[i].falloff = 1.001f / std::min(squared_distance(places[0].data(), places[1].data(), rest.size()),
                                               squared_distance(rest.data(), places[i].data(), rest.size()));
  return model;
}

// character_model() with three joints, which its head follows, and its teeth do not.
inline PackedModel body_model(std::uint64_t seed = 1) {
  PackedModel model = character_model(seed);
  model.character.joints = {
      {"neck", no_joint, {0, -1, 0, 0.5f, 1, 0, 0, 0, 0, 0, 1, 0}, {0, 1, 0, 0, -1, 0, 0, 0.5f, 0, 0, 1, 0}},
      {"head", 0, {2, 0, 0, 0, 0, 2, 0, 1, 0, 0, 2, 0}, {0, 0.5f, 0, -0.5f, -0.5f, 0, 0, 0.25f, 0, 0, 0.5f, 0}},
      {"jaw", 1, {1, 0, 0, 0, 0, 1, 0, 0.5f, 0, 0, 1, 0.25f}, {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0}}};
  model.character.skin.influences = 2;
  for (std::uint16_t v = 0; v < 30; ++v) {  // two joints, except for the first row
    const bool both = v >= 6 && v < 18;
    const float first = v >= 18 ? 0 : both ? 0.125f * float(1 + v % 4) : 1;
    model.character.skin.joints.insert(model.character.skin.joints.end(),
                                       {std::uint16_t(v < 18 ? 1 : 0), std::uint16_t(both ? 2 * (v % 2) : 0)});
    model.character.skin.weights.insert(model.character.skin.weights.end(), {first, both ? 1 - first : 0});
  }
  return model;
}

// character_model at two coarser levels of detail: of 19 and of 13 of its 30 vertices, with two and with one of its
// three coefficients that are not direct.
inline PackedModel levelled_model(std::uint64_t seed = 1) {
  PackedModel model = character_model(seed);
  model.order = {0,  1,  2,  5, 7,  8,  12, 13, 17, 18, 23, 24, 29, 3,  6,  9,
                 15, 20, 26, 4, 10, 11, 14, 16, 19, 21, 22, 25, 27, 28, 30, 31};
  Random random(seed, 3);
  model.row_blocks.clear();
  std::uint32_t row = 0;
  for (const std::uint32_t vertices : {9, 4, 4, 2, 5, 6, 2}) {
    model.row_blocks.push_back(random_row_block(random, row, 3 * vertices, {0, 2, 3, 4}, 0.5f));
    row += 3 * vertices;
  }
  model.row_blocks[1] = random_row_block(random, 27, 12, {0, 1, 2}, 0.5f);
  DetailLevel first{19, {4, 4, 3, 4, 4}, {0, 3, 15, 12, 3, 5, 17, 15, 6, 9, 15, 18, 20, 26, 24, 20, 23, 29, 26}};
  first.uv_corners.assign(first.polygon_corners.rbegin(), first.polygon_corners.rend());
  first.parts = {{3, {{2, 0}, {1, no_material}}}, {2, {{2, 1}}}};
  first.points = {{2, {128, 0}},  {0, {0, 128}}, {3, {1, 255}}, {4, {64, 64}}, {1, {0, 0}},  {5, {200, 10}},
                  {7, {100, 78}}, {8, {1, 1}},   {6, {255, 1}}, {5, {0, 200}}, {8, {50, 60}}};
  first.used_coefficients = {1, 1, 0};
  DetailLevel second{13, {4, 3, 4}, {0, 5, 17, 12, 1, 8, 7, 18, 23, 29, 24}};
  second.uv_corners = second.polygon_corners;
  second.parts = {{2, {{1, 0}, {1, no_material}}}, {1, {{1, 1}}}};
  second.points = {{0, {100, 0}}, {1, {20, 200}}, {2, {85, 86}}, {0, {12, 34}}, {3, {80, 90}}, {4, {0, 255}}};
  second.used_coefficients = {1, 0, 0};
  model.levels = {std::move(first), std::move(second)};
  return model;
}

// Gives a model that has the vertices and channels of character_model() four joints that its controls drive: a jaw with
// a tongue and a pin on it, of which the last has no numbers of its own, and a lid that turns, moves and grows. Not all
// vertices follow them.
inline void drive_joints(PackedModel& model, std::uint64_t seed = 1) {
  Random random(seed, 4);
  DrivenJoints& driven = model.rest.driven;
  driven.joints = {{"jaw", no_joint, joint_rotation, {1, 0, 0, 0.5f, 0, 1, 0, 1, 0, 0, 1, -1}},
                   {"tongue", 0, 0x23, {0, -1, 0, 0.5f, 1, 0, 0, 0.25f, 0, 0, 1, 0.5f}},
                   {"pin", 0, 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1}},
                   {"lid", no_joint, 0xfff, {0.6f, 0.8f, 0, -1, -0.8f, 0.6f, 0, 2, 0, 0, 1, 0}, {joint_rotation, 2}}};
  for (std::size_t n = 0; n < driven.number_count(); ++n) driven.scales.push_back(random.uniform(0.25f, 0.75f));
  for (std::size_t n = 6; n < 9; ++n) driven.scales[n] *= 32;  // the lid turns all the way round
  driven.skin.influences = 3;
  for (std::uint16_t v = 0; v < 30; ++v) {
    const float first = v % 5 == 0 ? 0 : 0.125f * float(1 + v % 5), second = v % 3 == 0 || first == 0 ? 0 : 0.25f;
    driven.skin.joints.insert(driven.skin.joints.end(), {std::uint16_t(v % 4), std::uint16_t((v + 1) % 4), 3});
    driven.skin.weights.insert(driven.skin.weights.end(), {first, second, second > 0 && v % 6 == 1 ? 0x1p-15f : 0});
  }
  const auto row = static_cast<std::uint32_t>(model.rest.points.size());
  constexpr std::uint32_t carriers = 8;
  for (std::uint32_t c = 0; c < carriers; ++c) {
    if (!model.order.empty()) model.order.push_back(row / 3 + c);
    for (int axis = 0; axis < 3; ++axis) model.rest.points.push_back(0);
  }
  model.rest.carrier_vertices += carriers;
  model.row_blocks.push_back(random_row_block(random, row, 3 * carriers, {0, 1, 2, 3, 4}, 0.5f));
  for (ExactPose& pose : model.exact)
    for (std::uint32_t r = 0; r < 3 * carriers; ++r)
      pose.values.push_back(static_cast<std::int32_t>(random.uniform(-1, 1) * 1e5f));
}

// character_model() with driven joints; with everything else that positions depend on, too.
inline PackedModel driven_model(std::uint64_t seed = 1) {
  PackedModel model = character_model(seed);
  drive_joints(model, seed);
  return model;
}
inline PackedModel whole_model(std::uint64_t seed = 1) {
  PackedModel model = levelled_model(seed);
  model.exact = exact_model(seed).exact;
  drive_joints(model, seed);
  return model;
}

// A pose within the controls' ranges.
inline std::vector<float> random_pose(const RigSchema& schema, Random& random) {
  std::vector<float> pose;
  for (const Control& control : schema.controls) pose.push_back(random.uniform(control.minimum, control.maximum));
  return pose;
}

}  // namespace fb
