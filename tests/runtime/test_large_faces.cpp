// Faces whose positions are written row block by row block (from 131,072 vertices on): the same bits as in baked order,
// where positions are the rows themselves. And poses that several threads share, of faces of 50,000 vertices or more.
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
PackedModel large_model(std::uint32_t grid_rows = down) {
  const std::uint32_t vertices = across * grid_rows;
  Random random(2);
  PackedModel model;
  model.rest = grid_mesh(across, grid_rows);
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

namespace {

// A host's scheduler that runs tasks in turn, on different workers, but for the last of them where it should not.
struct Host {
  std::size_t calls = 0, left_out = 0;
  static void run(void* user, std::uint32_t count, std::uint32_t workers, HostTask task, void* context) {
    Host& host = *static_cast<Host*>(user);
    ++host.calls;
    for (std::uint32_t i = 0; i + host.left_out < count; ++i) task(context, i, (count - i) % workers);
  }
  Parallel parallel() { return {.threads = 3, .host = run, .host_user = this}; }
};

std::vector<Workspace> three_workspaces(const Evaluator& face) {
  std::vector<Workspace> workspaces;
  for (int worker = 0; worker < 3; ++worker) workspaces.emplace_back(face, 1);
  return workspaces;
}

}  // namespace

TEST_CASE("a pose that threads share has the bits of one thread") {
  for (const std::uint32_t grid_rows : {down, 140u}) {
    const PackedModel model = large_model(grid_rows);
    const Evaluator face(model);
    const std::vector<float> poses = poses_of(2);
    std::vector<Workspace> workspaces = three_workspaces(face);
    Workspace alone(face);
    for (const VertexOrder order : {VertexOrder::baked, VertexOrder::source})
      for (const NumberFormat format : {NumberFormat::float32, NumberFormat::float16})
        for (const bool normals : {false, true}) {
          const std::size_t numbers = 2 * 3 * face.vertex_count();
          std::vector<float> positions[3], directions[3];
          Host host;
          for (int way = 0; way < 3; ++way) {
            positions[way].assign(numbers, -3.0f), directions[way].assign(numbers, -3.0f);
            Batch batch;
            batch.poses = 2;
            batch.controls = poses;
            batch.positions = {positions[way].data(), numbers};
            if (normals) batch.normals = {directions[way].data(), numbers};
            batch.order = order;
            batch.format = format;
            batch.spread = way > 0;
            if (way == 0)
              face.evaluate_batch(batch, {&alone, 1});
            else
              face.evaluate_batch(batch, workspaces, way == 1 ? host.parallel() : Parallel{.threads = 3});
          }
          CAPTURE(grid_rows);
          CAPTURE(normals);
          CHECK(host.calls >= 2);
          for (int way = 1; way < 3; ++way) {
            CHECK(std::memcmp(positions[way].data(), positions[0].data(), 4 * numbers) == 0);
            CHECK(std::memcmp(directions[way].data(), directions[0].data(), 4 * numbers) == 0);
          }
        }
  }
}

TEST_CASE("poses are shared only where that is wanted, and a host that leaves work out is told") {
  const Evaluator face(large_model(140)), smaller(large_model(130));
  const std::vector<float> poses = poses_of(3);
  const auto calls_of = [&](const Evaluator& of, std::size_t count, bool spread, std::size_t left_out = 0) {
    std::vector<Workspace> workspaces = three_workspaces(of);
    std::vector<float> positions(count * 3 * of.vertex_count());
    Host host{0, left_out};
    Batch batch;
    batch.poses = count;
    batch.controls = std::span(poses).first(count * controls);
    batch.positions = {positions.data(), positions.size()};
    batch.spread = spread;
    of.evaluate_batch(batch, workspaces, host.parallel());
    return host.calls;
  };
  CHECK(calls_of(face, 1, true) >= 2);
  CHECK(calls_of(face, 1, false) == 0);
  CHECK(calls_of(face, 3, true) == 1);  // a thread each
  CHECK(calls_of(smaller, 1, true) == 0);
  CHECK_THROWS_WITH_AS(calls_of(face, 1, true, 1), doctest::Contains("the host's parallel_for ran"), Error);
}

}  // namespace test_large_faces
