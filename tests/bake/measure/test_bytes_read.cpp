#include "bake/measure/bytes_read.h"

#include <doctest/doctest.h>

#include <array>

#include "base/status.h"
#include "memory_source.h"

namespace test_bytes_read {

using namespace fb;
using namespace fb::bake;

namespace {

using Pose = std::array<float, 3>;

PackedLayer layer(std::uint32_t inputs, std::uint32_t outputs, bool wide) {
  PackedLayer result;
  result.inputs = inputs;
  result.outputs = outputs;
  result.wide = wide;
  result.weights.resize(std::size_t(inputs) * outputs);
  result.scales.resize(outputs);
  result.bias.resize(outputs);
  return result;
}

PackedRowBlock group(std::uint32_t first, std::uint32_t rows, std::pmr::vector<PackedColumn> columns) {
  PackedRowBlock result{first, rows, columns, {}};
  result.values.resize(columns.size() * rows);
  return result;
}

// 3 controls, the last at 0.5 in the rest pose, and a feature each; 4 vertices; feature 0 is direct; a region of all
// features with a gate on the first two gives 2 coefficients.
PackedModel counted_model(const Source& source) {
  PackedModel model;
  model.schema = source.schema();
  model.rest = source.rest();
  for (std::uint32_t c = 0; c < 3; ++c) model.features.push_back({.kind = Feature::Kind::identity, .control = c});
  model.direct = {0};
  model.regions.push_back({"region", {0, 1, 2}, {layer(3, 10, false), layer(10, 2, true)}, {{0, 1, 2}}});
  model.columns = 3;
  model.row_blocks = {group(0, 6, {{0, false, 1}, {1, false, 1}}), group(6, 6, {{0, true, 1}, {2, true, 1}})};
  return model;
}

constexpr std::uint64_t always = 3 * 12 + 3 * 20 + 1 * 4 + (3 + 3) * 4 + 4 * 12;
constexpr std::uint64_t direct = (6 + 8) + (6 * 2 + 8);
constexpr std::uint64_t region = (10 * 8) + (10 * 2 * 2 + 2 * 8) + (6 + 8) + (6 * 2 + 8);
constexpr std::uint64_t input = 10;

MemorySource three_controls() {
  MemorySource source(3, 2, [](const float*, std::span<float>) {});
  source.edit_schema().controls[2].rest = 0.5f;
  return source;
}

}  // namespace

TEST_CASE("a pose reads what moves") {
  const MemorySource source = three_controls();
  PackedModel model = counted_model(source);
  const BytesReadCounter count(model);
  CHECK(count.of_pose(Pose{0, 0, 0.5f}) == always);
  CHECK(count.of_pose(Pose{1, 0, 0.5f}) == always + direct);  // the gate is closed
  CHECK(count.of_pose(Pose{0, 0, 0}) == always);
  CHECK(count.of_pose(Pose{0, -0.25f, 0.75f}) == always + region + 2 * input);
  CHECK(count.of_pose(Pose{1, 1, 1}) == always + direct + region + 3 * input);
  CHECK(count.of_pose(Pose{1, 1, 1}) == count.total());
  CHECK_THROWS_AS(count.of_pose(std::array{1.0f, 2.0f}), Error);

  model.order = {1, 0, 3, 2};
  CHECK(BytesReadCounter(model).of_pose(Pose{0, 0, 0.5f}) == always + 4 * 4);
  model.regions[0].gate.features.clear();
  CHECK(BytesReadCounter(model).of_pose(Pose{0, 0, 1}) == always + 4 * 4 - 3 * 4 + region + input);
  model.regions[0].features = {0, 1};
  CHECK(BytesReadCounter(model).of_pose(Pose{0, 0, 1}) == always + 4 * 4 - 4 * 4);  // nothing of the region's moves
}

TEST_CASE("mean, the most and nearly the most of poses") {
  MemorySource source = three_controls();
  source.add_clip("clip", ClipKind::shot, Split::test, 40, 0.0f, 1);
  source.edit_clip(0).controls[3 * 7] = 1;  // one frame moves the direct feature, one everything
  for (std::size_t c = 0; c < 3; ++c) source.edit_clip(0).controls[3 * 20 + c] = 1;
  const PackedModel model = counted_model(source);
  const BytesRead bytes = bytes_read_per_pose(model, PoseSet(source, [](const Clip&) { return true; }));
  CHECK(bytes.poses == 40);
  CHECK(bytes.mean == doctest::Approx(always + (2.0 * direct + region + 3 * input) / 40));
  CHECK(bytes.p95 == always);
  CHECK(bytes.max == bytes.runtime_bytes);
  source.edit_clip(0).controls[3 * 8] = 1;
  CHECK(bytes_read_per_pose(model, PoseSet(source, [](const Clip&) { return true; })).p95 == always + direct);

  const BytesRead none = bytes_read_per_pose(model, PoseSet(source, [](const Clip&) { return false; }));
  CHECK(none.poses == 0);
  CHECK(none.mean == 0);
  CHECK(none.runtime_bytes == bytes.runtime_bytes);

  source.add_clip("long", ClipKind::shot, Split::test, 3000, 0.5f, 2);
  CHECK(bytes_read_per_pose(model, PoseSet(source, [](const Clip&) { return true; })).poses == 500);
}

}  // namespace test_bytes_read
