#include <doctest/doctest.h>
#include <facebaker/facebaker_solve.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace {

const std::uint32_t chosen_controls[] = {0, 2, 3};

fb_jacobian_desc chosen_of(const std::vector<float>& pose) {
  fb_jacobian_desc desc;
  fb_jacobian_desc_init(&desc);
  desc.controls = pose.data();
  desc.chosen = chosen_controls;
  desc.chosen_count = 3;
  return desc;
}

std::vector<float> pose_of(const facebaker::Model& model, float jaw) {
  std::vector<float> pose = model.rest_controls();
  pose[model.find("jaw_open")] = jaw;
  return pose;
}

}  // namespace

TEST_CASE("sparse derivatives are the dense ones, and their memory is used again") {
  facebaker::Solver solver(facebaker::Model(FB_FIXTURE));  // keeps the face
  const facebaker::Model& model = solver.model();
  REQUIRE(solver.point_count() == model.vertex_count());
  REQUIRE(solver.row_count() == 3 * model.vertex_count());
  const std::size_t rows = solver.row_count(), controls = model.control_count();
  facebaker::SparseColumns columns;
  std::vector<float> dense(rows * controls), values(rows), positions(rows);
  for (const float jaw : {0.5f, 0.25f, 0.75f}) {
    const std::vector<float> pose = pose_of(model, jaw);
    solver.jacobian(pose.data(), dense.data());
    fb_jacobian_desc desc = chosen_of(pose);
    desc.values = values.data();
    solver.jacobian(desc, columns);
    facebaker::Scratch(model).evaluate(pose.data(), positions.data());
    for (std::size_t row = 0; row < rows; ++row) CHECK(std::fabs(values[row] - positions[row]) < 1e-5f);
    REQUIRE(columns.starts.size() == 4);
    REQUIRE(columns.rows.size() == columns.starts.back());
    REQUIRE(columns.values.size() == columns.rows.size());
    std::vector<float> again(rows * controls);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t e = columns.starts[c]; e < columns.starts[c + 1]; ++e)
        again[columns.rows[e] * controls + chosen_controls[c]] = columns.values[e];
    for (std::size_t row = 0; row < rows; ++row)
      for (const std::uint32_t control : chosen_controls)
        CHECK(again[row * controls + control] == dense[row * controls + control]);
  }
}

TEST_CASE("nothing is followed, so no column has an entry") {
  const facebaker::Model model(FB_FIXTURE);
  fb_solver_desc of;
  fb_solver_desc_init(&of);
  const std::uint32_t none = 0;
  of.point_vertices = &none;
  facebaker::Solver solver(model, &of);
  CHECK(solver.row_count() == 0);
  facebaker::SparseColumns columns;
  const std::vector<float> pose = model.rest_controls();
  solver.jacobian(chosen_of(pose), columns);
  CHECK(columns.starts == std::vector<std::uint64_t>(4));
  CHECK(columns.rows.empty());
}

TEST_CASE("a pose is found again") {
  const facebaker::Model model(FB_FIXTURE);
  facebaker::Solver solver(model);
  std::vector<float> positions(solver.row_count()), found = model.rest_controls();
  facebaker::Scratch(model).evaluate(pose_of(model, 0.5f).data(), positions.data());
  const fb_solve_result result = solver.solve(positions.data(), found.data());
  CHECK(result.converged == 1);
  CHECK(result.point_count == model.vertex_count());
  CHECK(result.max_difference < 5e-3 * fb_diagonal(model.get()));
  CHECK(std::fabs(found[model.find("jaw_open")] - 0.5f) < 0.02f);
}

TEST_CASE("errors of solving are exceptions with a status") {
  const facebaker::Model model(FB_FIXTURE);
  facebaker::Solver solver(model);
  std::vector<float> targets(solver.row_count()), found = model.rest_controls();
  targets[4] = INFINITY;
  try {
    solver.solve(targets.data(), found.data());
    FAIL("no exception");
  } catch (const facebaker::Error& error) {
    CHECK(error.status() == FB_ERROR_NOT_FINITE);
    CHECK(std::string(error.what()).find("point 1") != std::string::npos);
  }
  CHECK(found == model.rest_controls());
  found[1] = NAN;
  CHECK_THROWS_AS(solver.jacobian(found.data(), nullptr), facebaker::Error);
}
