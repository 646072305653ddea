// What derivatives and solving cost, in poses' time: of 68 points that are spread over what moves, and of all vertices,
// on a clip in which a fifth of the controls swing.
//   bench_solve FACE.fbk [FRAMES]
// Frames are solved each from the one before, with the default preferences, and once more with 100 iterations: the
// share by which the first ends above the second is what converging costs.
#include <facebaker/facebaker_solve.h>
#include <facebaker/facebaker.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <vector>

namespace {

using Floats = std::vector<float>;

double median_us(int times, const std::function<void(int)>& run) {
  std::vector<double> taken;
  for (int i = 0; i < times; ++i) {
    const auto start = std::chrono::steady_clock::now();
    run(i);
    taken.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
  }
  std::nth_element(taken.begin(), taken.begin() + times / 2, taken.end());
  return taken[static_cast<std::size_t>(times / 2)];
}

// Every fifth control swings between rest and the farther end of its range, each at its own pace.
Floats pose_at(const facebaker::Model& model, int frame) {
  Floats pose(fb_rest_controls(model.get()), fb_rest_controls(model.get()) + model.control_count());
  for (std::uint32_t c = 0; c < pose.size(); c += 5) {
    const fb_control control = model.control(c);
    const float end = control.maximum > control.rest ? control.maximum : control.minimum;
    const double share = 0.6 * std::fabs(std::sin(0.01 * frame * (1 + c % 7) + c));
    pose[c] += static_cast<float>(share) * (end - pose[c]);
  }
  return pose;
}

// The vertices that move farthest, each far from those before it.
std::vector<std::uint32_t> spread_points(const facebaker::Model& model, facebaker::Scratch& scratch,
                                         std::size_t count) {
  const std::size_t vertices = model.vertex_count();
  const float* const rest = fb_rest_positions(model.get());
  Floats positions(3 * vertices), moved(vertices), apart(vertices, 1e30f);
  for (int frame = 0; frame < 200; frame += 10) {
    scratch.evaluate(pose_at(model, frame).data(), positions.data());
    for (std::size_t v = 0; v < vertices; ++v)
      for (std::size_t a = 0; a < 3; ++a)
        moved[v] = std::max(moved[v], std::fabs(positions[3 * v + a] - rest[3 * v + a]));
  }
  const float enough = 1e-3f * static_cast<float>(fb_diagonal(model.get()));
  std::vector<std::uint32_t> chosen = {
      static_cast<std::uint32_t>(std::max_element(moved.begin(), moved.end()) - moved.begin())};
  while (chosen.size() < count) {
    std::uint32_t next = chosen.back();
    for (std::uint32_t v = 0; v < vertices; ++v) {
      double squares = 0;
      for (std::size_t a = 0; a < 3; ++a) squares += std::pow(rest[3 * v + a] - rest[3 * chosen.back() + a], 2);
      apart[v] = std::min(apart[v], static_cast<float>(squares));
      if (moved[v] > enough && apart[v] > apart[next]) next = v;
    }
    chosen.push_back(next);
  }
  return chosen;
}

void measure(const facebaker::Model& model, facebaker::Scratch& scratch, const std::vector<std::uint32_t>& points,
             int frames, double pose_us) {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t point : points) vertices.insert(vertices.end(), {point, point, point});
  const Floats weights = [&] {
    Floats of(vertices.size());
    for (std::size_t i = 0; i < of.size(); i += 3) of[i] = 1;
    return of;
  }();
  fb_solver_desc desc;
  fb_solver_desc_init(&desc);
  desc.point_count = static_cast<std::uint32_t>(points.size());
  desc.point_vertices = points.empty() ? nullptr : vertices.data();
  desc.point_weights = weights.data();
  fb_solver* solver = nullptr;
  facebaker::check(fb_solver_create(model.get(), &desc, &solver));
  fb_jacobian_desc jacobian;
  fb_jacobian_desc_init(&jacobian);
  const Floats middle = pose_at(model, 30);
  jacobian.controls = middle.data();
  const double derivative_us =
      median_us(points.empty() ? 9 : 99, [&](int) { facebaker::check(fb_jacobian(solver, &jacobian)); });
  Floats controls = pose_at(model, 0), positions(3 * std::size_t(model.vertex_count())), targets, best;
  double excess = 0, worst_excess = 0, iterations = 0;
  fb_solve_desc solve;
  fb_solve_desc_init(&solve);
  const fb_solve_desc usual = solve;
  fb_solve_result result;
  fb_solve_result_init(&result);
  std::vector<double> taken;
  for (int frame = 1; frame <= frames; ++frame) {
    scratch.evaluate(pose_at(model, frame).data(), positions.data());
    targets = positions;
    if (!points.empty()) targets.clear();
    for (const std::uint32_t point : points)
      targets.insert(targets.end(), positions.begin() + 3 * point, positions.begin() + 3 * point + 3);
    solve.points = targets.data();
    best = controls;
    solve.controls = controls.data();
    solve.max_iterations = usual.max_iterations;
    solve.tolerance = usual.tolerance;
    taken.push_back(median_us(1, [&](int) { facebaker::check(fb_solve(solver, &solve, &result)); }));
    const double objective = result.objective;
    iterations += result.iterations;
    solve.controls = best.data();
    solve.max_iterations = 100;
    solve.tolerance = 0;
    facebaker::check(fb_solve(solver, &solve, &result));
    const double above = result.objective > 0 ? objective / result.objective - 1 : 0;
    excess += above;
    worst_excess = std::max(worst_excess, above);
  }
  fb_solver_destroy(solver);
  std::nth_element(taken.begin(), taken.begin() + frames / 2, taken.end());
  const double frame_us = taken[static_cast<std::size_t>(frames / 2)];
  std::printf(
      "%6zu points: derivatives %9.1f us, %6.1f poses; a frame %9.1f us, %6.1f poses, %.1f iterations, %.2f %% above "
      "100 iterations on average, %.2f %% at most\n",
      points.empty() ? std::size_t(model.vertex_count()) : points.size(), derivative_us, derivative_us / pose_us,
      frame_us, frame_us / pose_us, iterations / frames, 100 * excess / frames, 100 * worst_excess);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "bench_solve FACE.fbk [FRAMES]\n");
    return 2;
  }
  const facebaker::Model model(argv[1]);
  facebaker::Scratch scratch(model);
  const int frames = argc > 2 ? std::max(1, std::atoi(argv[2])) : 60;
  Floats positions(3 * std::size_t(model.vertex_count()));
  const Floats pose = pose_at(model, 30);
  const double pose_us = median_us(301, [&](int) { scratch.evaluate(pose.data(), positions.data()); });
  std::printf("a pose: %.1f us (%s)\n", pose_us, fb_instruction_set(model.get()));
  measure(model, scratch, spread_points(model, scratch, 68), frames, pose_us);
  measure(model, scratch, {}, std::max(1, frames / 4), pose_us);
  return 0;
}
