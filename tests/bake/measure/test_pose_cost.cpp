#include "bake/measure/pose_cost.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <string>

#include "bake/measure/calibrate_machine.h"
#include "base/random.h"
#include "base/status.h"

namespace test_pose_cost {

using namespace fb;
using namespace fb::bake;

namespace {

using Pose = std::array<float, 3>;

PackedLayer layer(std::uint32_t inputs, std::uint32_t outputs, bool wide) {
  PackedLayer result;
  result.inputs = inputs;
  result.outputs = outputs;
  result.wide = wide;
  return result;
}

// 3 controls and a feature each; 4 vertices; feature 0 is direct; a region of all features with a gate on the first two
// gives 2 coefficients.
PackedModel counted_model() {
  PackedModel model;
  for (std::uint32_t c = 0; c < 3; ++c) {
    model.schema.controls.push_back({"control " + std::to_string(c), 0, 1, 0, ""});
    model.features.push_back({.kind = Feature::Kind::identity, .control = c});
  }
  model.rest.points.resize(12);
  model.direct = {0};
  model.regions.push_back({"region", {0, 1, 2}, {layer(3, 10, false), layer(10, 2, true)}, {{0, 1}}});
  model.columns = 3;
  model.row_blocks = {{0, 6, {{0, false, 1}, {1, false, 1}}, {}}, {6, 6, {{0, true, 1}, {2, true, 1}}, {}}};
  return model;
}

// A class on which only one kind of work takes time, a microsecond each.
MachineClass only(const char* work) {
  MachineClass machine;
  const auto found = std::find(pose_work_names.begin(), pose_work_names.end(), std::string(work));
  machine.nanoseconds.at(static_cast<std::size_t>(found - pose_work_names.begin())) = 1000;
  return machine;
}

void check_refused(const std::string& machine, Status status, const char* words) {
  try {
    find_machine(machine);
    FAIL("taken: ", machine);
  } catch (const Error& error) {
    CHECK(error.status() == status);
    CHECK_MESSAGE(std::string(error.what()).find(words) != std::string::npos, error.what());
  }
}

}  // namespace

TEST_CASE("the work of a pose is counted from the packed model") {
  const PackedModel model = counted_model();
  const PoseWorkCounter counter(model);
  // poses, controls, vertices, entries, layers, weights, blocks, moved, coefficients, summands, misses
  CHECK(counter.of_pose(Pose{0, 0, 0}) == PoseWork{1, 6, 4, 0, 0, 0, 2, 0, 0, 0, 0});
  // The gate is closed: feature 0 is an input of the region, of its gate and, twice where columns are wide, of blocks.
  CHECK(counter.of_pose(Pose{1, 0, 0}) == PoseWork{1, 6, 4, 5, 0, 0, 2, 2, 0, 8, 0});
  CHECK(counter.of_pose(Pose{1, 1, 1}) == PoseWork{1, 6, 4, 8, 2, (3 * 10 + 2 * 20) / 64.0, 2, 2, 3, 8, 0});
  CHECK_THROWS_AS(counter.of_pose(std::array{1.0f, 2.0f}), Error);
}

TEST_CASE("summands are fours of inputs in strips of 64 rows") {
  PackedModel model = counted_model();
  model.regions[0].gate.features.clear();
  model.row_blocks[1].row_count = 129;
  const PoseWorkCounter counter(model);
  CHECK(only("summands").microseconds(counter.of_pose(Pose{1, 0, 0})) == 4 + 3 * 4);
  for (std::uint32_t column = 3; column < 6; ++column) model.row_blocks[1].columns.push_back({0, false, 1});
  // 2 + 2 + 3 inputs are two fours.
  CHECK(only("summands").microseconds(PoseWorkCounter(model).of_pose(Pose{1, 0, 0})) == 4 + 3 * 8);
}

TEST_CASE("more work costs more on every class, and what the caches do not hold costs more again") {
  const PackedModel model = counted_model();
  PackedModel wider = model, large = model;
  wider.row_blocks[0].columns.assign(9, {0, true, 1});
  large.rest.points.resize(3 * 40'000);
  for (const std::string& name : machine_names()) {
    const MachineClass machine = find_machine(name);
    const auto cost = [&](const PackedModel& face, const Pose& pose) {
      return machine.microseconds(PoseWorkCounter(face).of_pose(pose));
    };
    CHECK(cost(model, {1, 0, 0}) > cost(model, {0, 0, 0}));
    CHECK(cost(model, {1, 1, 1}) > cost(model, {1, 0, 0}));
    CHECK(cost(wider, {1, 0, 0}) > cost(model, {1, 0, 0}));
    CHECK(cost(large, {0, 0, 0}) > cost(model, {0, 0, 0}));
  }
  CHECK(only("misses").microseconds(PoseWorkCounter(large).of_pose(Pose{0, 0, 0})) ==
        doctest::Approx(40'000 * 28 / 64.0 - 16384));
  Clip clip;
  clip.frames = 2;
  clip.controls = {0, 0, 0, 1, 0, 0};
  CHECK(mean_microseconds(model, clip, only("entries")) == 2.5);
}

TEST_CASE("narrower registers take longer on a face of useful size") {
  PackedModel face = counted_model();
  face.rest.points.resize(3 * 5000);
  face.regions[0].layers = {layer(3, 64, false), layer(64, 64, false), layer(64, 2, false)};
  face.row_blocks.clear();
  for (std::uint32_t row = 0; row < 15'000; row += 125) {
    face.row_blocks.push_back({row, 125, {}, {}});
    for (std::uint32_t column = 0; column < 40; ++column)
      face.row_blocks.back().columns.push_back({column % 3, false, 1});
  }
  const PoseWork work = PoseWorkCounter(face).of_pose(Pose{1, 1, 1});
  CHECK(find_machine("avx2").microseconds(work) > 1.1 * find_machine("avx512-vnni").microseconds(work));
}

TEST_CASE("machines are known by name or by document") {
  CHECK(find_machine("").name == "avx512-vnni");
  CHECK(find_machine("avx2").name == "avx2");
  check_refused("abacus", Status::not_found, "\"abacus\"; there are avx512-vnni, avx2");
  check_refused("{}", Status::bad_data, "facebaker-machine");
  check_refused("{", Status::bad_data, "facebaker-machine");
  const std::string begin = R"({"format": "facebaker-machine", "version": 1, "name": "mine", "processor": "p")";
  check_refused(begin + "}", Status::bad_data, "\"poses\"");
  std::string nanoseconds;
  for (const char* work : pose_work_names)
    nanoseconds += (nanoseconds.empty() ? "\"" : ", \"") + std::string(work) + "\": 2.5";
  const MachineClass mine = find_machine(begin + ", \"nanoseconds\": {" + nanoseconds + "}}");
  CHECK(mine.name == "mine");
  CHECK(mine.microseconds({4}) == 0.01);
  const std::size_t last = nanoseconds.rfind("2.5");
  check_refused(begin + ", \"nanoseconds\": {" + nanoseconds.replace(last, 3, "-1") + "}}", Status::bad_data,
                "\"misses\"");
}

TEST_CASE("constants are fitted to what was timed, and none is negative") {
  PoseWork truth = {};
  for (std::size_t i = 0; i < truth.size(); ++i) truth[i] = double(i % 3);  // some are 0
  Random random(5);
  std::vector<TimedWork> cases(60);
  for (TimedWork& timed : cases) {
    for (double& count : timed.work) count = 100 * random.uniform();
    for (std::size_t i = 0; i < truth.size(); ++i) timed.microseconds += 1e-3 * truth[i] * timed.work[i];
  }
  const PoseWork fitted = fit_nanoseconds(cases);
  for (std::size_t i = 0; i < truth.size(); ++i) CHECK(fitted[i] == doctest::Approx(truth[i]).epsilon(1e-3).scale(1));
  // What shortens a pose is not believed.
  for (TimedWork& timed : cases) timed.microseconds = 1 + 0.5e-3 * (100 - timed.work[1]);
  for (const double constant : fit_nanoseconds(cases)) CHECK(constant >= 0);
}

}  // namespace test_pose_cost
