// Faces whose positions are written row block by row block (from 131,072 vertices on): the same bits as in baked order,
// where positions are the rows themselves.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>

#include "runtime/evaluator.h"
#include "test_models.h"

namespace test_large_faces {

using namespace fb;
using namespace fb::runtime;

namespace {

constexpr std::uint32_t across = 374, down = 375, vertices = across * down, block_vertices = 64, controls = 4;

// Every control moves some row blocks, two of them many; a third of the blocks is at rest in all poses. One pose is
// exact.
PackedModel large_model() {
  Random random(2);
  PackedModel model;
  model.rest = grid_mesh(across, down);
  for (std::uint64_t v = 0; v < vertices; ++v) model.order.push_back(std::uint32_t(v * 7919 % vertices));
  for (std::uint32_t c = 0; c < controls; ++c) {
    model.schema.controls.push_back({"control " + std::to_string(c), -1, 1, 0, ""});
    model.features.push_back({Feature::Kind::identity, c});
    model.direct.push_back(c);
  }
  model.columns = controls;
  for (std::uint32_t first = 0; first < 3 * vertices; first += 3 * block_vertices) {
    PackedRowBlock block{first, std::min(3 * block_vertices, 3 * vertices - first), {}, {}};
    for (std::uint32_t c = 0; c < controls; ++c)
      if (first % 9 != 0 && random.uniform() < (c < 2 ? 0.6f : 0.1f)) block.columns.push_back({c, false, 1e-4f});
    block.values = random_numbers(random, block.row_count * block.columns.size(), largest_narrow);
    model.row_blocks.push_back(std::move(block));
  }
  ExactPose exact{"exact", {0, 0, 0, 1}, 4, 1e-3f, {}};
  for (std::uint32_t row = 0; row < 3 * vertices; ++row) exact.values.push_back(row / 3000 % 5 == 0 ? int(row % 7) : 0);
  model.exact.push_back(std::move(exact));
  check(model);
  return model;
}

std::vector<float> poses_of(std::size_t count) {
  Random random(5);
  std::vector<float> poses(controls);  // rest
  while (poses.size() < count * controls) poses.push_back(random.uniform() < 0.6f ? random.uniform(-1, 1) : 0.0f);
  poses[(count - 1) * controls + 3] = 0.9f;  // within reach of the exact one
  return poses;
}

}  // namespace

TEST_CASE("positions of large faces have the same bits in either order, alone and together, however they are written") {
  const PackedModel model = large_model();
  const Evaluator face(model);
  Workspace workspace(face);
  const std::size_t size = 3 * vertices, count = poses_per_block + 2;
  const std::vector<float> poses = poses_of(count);
  struct Layout {
    std::size_t stride;
    NumberFormat format;
    bool displacements, bounds;
  };
  for (const Layout& layout :
       {Layout{3, NumberFormat::float32, false, false}, Layout{5, NumberFormat::float32, false, true},
        Layout{3, NumberFormat::float32, true, false}, Layout{4, NumberFormat::float16, false, false},
        Layout{3, NumberFormat::float16, true, false}}) {
    for (const std::size_t together : {std::size_t{1}, count}) {
      const auto [stride, format, displacements, bounds] = layout;
      CAPTURE(layout.stride);
      CAPTURE(together);
      std::vector<float> box(6 * together);
      std::vector<std::vector<float>> written;
      for (const VertexOrder order : {VertexOrder::baked, VertexOrder::source}) {
        std::vector<float>& all = written.emplace_back(count * vertices * stride, -3.0f);
        for (std::size_t first = 0; first < count; first += together) {
          Batch batch;
          batch.poses = together;
          batch.controls = std::span(poses).subspan(first * controls, together * controls);
          // Halves are of half the size: those of a pose begin where its floats would.
          const std::size_t numbers = format == NumberFormat::float16 ? 2 : 1;
          batch.positions = {all.data() + first * vertices * stride, together * vertices * stride * numbers,
                             vertices * stride * numbers, stride};
          batch.order = order;
          batch.format = format;
          batch.displacements = displacements;
          if (bounds) batch.bounds = {box.data(), box.size()};
          face.evaluate_batch(batch, {&workspace, 1});
        }
      }
      const std::size_t number = format == NumberFormat::float16 ? 2 : 4;
      std::size_t different = 0;
      for (std::size_t pose = 0; pose < count; ++pose)
        for (std::uint32_t i = 0; i < vertices; ++i) {
          const auto* baked = reinterpret_cast<const char*>(&written[0][pose * vertices * stride]);
          const auto* source = reinterpret_cast<const char*>(&written[1][pose * vertices * stride]);
          different +=
              std::memcmp(baked + number * stride * i, source + number * stride * model.order[i], 3 * number) != 0;
        }
      CHECK(different == 0);
    }
  }
  std::vector<float> points(size);
  face.evaluate(poses.data(), points.data(), workspace);
  CHECK(points == model.rest.points);
}

}  // namespace test_large_faces
