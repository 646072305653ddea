#include <facebaker/facebaker_solve.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "abi_guard.h"
#include "base/length_units.h"
#include "runtime/float_mode.h"
#include "runtime/solve/pose_solver.h"
#include "scratch.h"

using fb::fail;
using fb::Status;
using fb::capi::abi_guard;
using fb::capi::fill_struct;
using fb::capi::read_struct;
using fb::capi::require;
using fb::runtime::Followed;
using fb::runtime::PointGroup;
using fb::runtime::PointPair;
using fb::runtime::PoseDerivative;
using fb::runtime::PoseSolver;
using fb::runtime::RigidMotion;
using fb::runtime::SolvePreferences;
using fb::runtime::SolveResult;
using fb::runtime::SolveTargets;
using fb::runtime::WeightedPoint;

namespace {

constexpr std::size_t frame_floats = 12;

// A description of what is followed, with vertices in baked order.
struct FollowedLists {
  FollowedLists(const fb_model& model, const fb_solver_desc& desc)
      : points(&model.memory), pairs(&model.memory), sockets(&model.memory), joints(&model.memory), lod(desc.lod) {
    const auto& index = model.evaluator.layout().baked_index;
    const std::size_t vertices = model.evaluator.vertex_count();
    const auto baked = [&](std::uint32_t vertex) { return index.empty() ? vertex : index[vertex]; };
    const std::size_t count = desc.point_vertices ? desc.point_count : vertices;
    points.reserve(count);
    for (std::uint32_t p = 0; p < count; ++p) {
      WeightedPoint& point = points.emplace_back(WeightedPoint{{baked(p < vertices ? p : 0), 0, 0}, {1, 0, 0}});
      for (std::size_t k = 0; k < 3 && desc.point_vertices; ++k) {
        const std::uint32_t vertex = desc.point_vertices[3 * std::size_t(p) + k];
        if (desc.point_weights) point.weights[k] = desc.point_weights[3 * std::size_t(p) + k];
        if (!std::isfinite(point.weights[k]))
          fail(Status::invalid_argument, "fb_solver_desc: weight %zu of point %u is not finite", k, p);
        if (point.weights[k] != 0 && vertex >= vertices)
          fail(Status::invalid_argument, "fb_solver_desc: point %u has vertex %u of %zu", p, vertex, vertices);
        point.vertices[k] = point.weights[k] != 0 ? baked(vertex) : 0;
      }
    }
    for (std::size_t k = 0; desc.pairs && k < desc.pair_count; ++k) {
      pairs.push_back({desc.pairs[2 * k], desc.pairs[2 * k + 1]});
      for (const std::uint32_t point : {pairs[k].first, pairs[k].second})
        if (point >= count)
          fail(Status::invalid_argument, "fb_solver_desc: pair %zu has point %u of %zu", k, point, count);
    }
    add(desc.sockets, desc.socket_count, model.evaluator.socket_count(), "socket", sockets);
    add(desc.joints, desc.joint_count, model.evaluator.joint_count(), "driven joint", joints);
    if (!(lod >= 0)) fail(Status::invalid_argument, "fb_solver_desc: lod is below 0 or not a number");
  }

  static void add(const std::uint32_t* list, std::size_t count, std::size_t all, const char* what,
                  std::pmr::vector<std::uint32_t>& to) {
    for (std::size_t i = 0; list && i < count; ++i) {
      if (list[i] >= all) fail(Status::invalid_argument, "fb_solver_desc: %s %u of %zu", what, list[i], all);
      to.push_back(list[i]);
    }
  }
  Followed followed() const { return {points, sockets, joints, lod}; }

  std::pmr::vector<WeightedPoint> points;
  std::pmr::vector<PointPair> pairs;
  std::pmr::vector<std::uint32_t> sockets, joints;
  float lod;
};

}  // namespace

struct fb_solver {
  fb_solver(const fb_model* model, const fb_solver_desc& desc) : fb_solver(model, FollowedLists(*model, desc)) {}
  fb_solver(const fb_model* model, const FollowedLists& lists)
      : owner(model),
        solver(model->evaluator, lists.followed(), lists.pairs, model->memory),
        points(lists.points.size()),
        pairs(lists.pairs.size()),
        frames(lists.sockets.size() + lists.joints.size()),
        rest_points(3 * points, &model->memory),
        targets(3 * points + frame_floats * frames, &model->memory),
        weights(points + pairs + frames, &model->memory),
        controls(model->evaluator.control_count(), &model->memory) {
    std::copy(model->rest_pose.begin(), model->rest_pose.end(), controls.begin());
    fb::runtime::with_float_mode([&] { solver.derivative().find_positions(controls.data()); });
    for (std::size_t p = 0; p < points; ++p) {
      const std::array<float, 3> at = solver.derivative().position(p);
      std::copy(at.begin(), at.end(), rest_points.begin() + std::ptrdiff_t(3 * p));
    }
  }

  std::atomic<bool> busy = false;
  fb::capi::Reference owner;  // before the members that use the model's memory
  PoseSolver solver;
  std::size_t points, pairs, frames;
  std::pmr::vector<float> rest_points;
  std::pmr::vector<float> targets, weights;  // of points and frames; of points, pairs and frames
  std::pmr::vector<float> controls;
};

namespace {

// A call's use of a solver.
class SolverUse {
 public:
  explicit SolverUse(fb_solver* solver) : solver_(*solver) {
    if (solver_.busy.exchange(true, std::memory_order_acquire))
      fail(Status::invalid_argument, "solver is in use by another call; each thread needs its own");
  }
  ~SolverUse() { solver_.busy.store(false, std::memory_order_release); }
  SolverUse(const SolverUse&) = delete;
  SolverUse& operator=(const SolverUse&) = delete;

 private:
  fb_solver& solver_;
};

std::size_t row_count(const fb_solver& solver) {
  return 3 * solver.points + frame_floats * solver.frames;
}

void refuse_nan(const fb_solver& solver, const float* controls, const char* what) {
  const auto& evaluator = solver.owner.model->evaluator;
  const std::size_t control = evaluator.find_nan(controls);
  if (control < evaluator.control_count())
    fail(Status::not_finite, "%s: control \"%s\" is not a number", what,
         evaluator.schema().controls[control].name.c_str());
}

// ---- Derivatives ----

// The derivative of a row by a control, of the last pose.
class RowReader {
 public:
  explicit RowReader(const fb_solver& solver) : solver_(solver), pose_(solver.solver.derivative()) {}

  float value(std::size_t row) const {
    if (row < 3 * solver_.points) return pose_.position(row / 3)[row % 3];
    return pose_.frames().frames()[row - 3 * solver_.points];
  }
  // write(row, derivative) for every row that the control may move, points by groups.
  template <class Write>
  void visit_column(std::uint32_t control, const Write& write) const {
    for (const PointGroup& group : pose_.groups()) {
      const auto of = group.controls();
      const auto at = std::lower_bound(of.begin(), of.end(), control);
      if (at == of.end() || *at != control) continue;
      const float* const column = group.by_control(static_cast<std::size_t>(at - of.begin()));
      for (std::size_t p = 0; p < group.numbers().size(); ++p)
        for (std::size_t axis = 0; axis < 3 && group.numbers()[p] < solver_.points; ++axis)
          write(3 * std::size_t(group.numbers()[p]) + axis, column[axis * group.stride() + p]);
    }
    for (std::size_t i = 0; i < frame_floats * solver_.frames; ++i)
      write(3 * solver_.points + i, pose_.frames().by_control(control)[i]);
  }

 private:
  const fb_solver& solver_;
  const PoseDerivative& pose_;
};

std::uint32_t chosen_control(const fb_jacobian_desc& desc, std::size_t index) {
  return desc.chosen ? desc.chosen[index] : static_cast<std::uint32_t>(index);
}

void write_dense(const fb_solver& solver, const fb_jacobian_desc& desc, std::size_t chosen) {
  const std::size_t rows = row_count(solver);
  std::fill_n(desc.derivatives, rows * chosen, 0.0f);
  for (std::size_t c = 0; c < chosen; ++c)
    RowReader(solver).visit_column(chosen_control(desc, c), [&](std::size_t row, float derivative) {
      desc.derivatives[row * chosen + c] = derivative;
    });
}

// Entries are sorted by rows, as groups have points in an order of their own.
void write_columns(fb_solver& solver, const fb_jacobian_desc& desc, std::size_t chosen) {
  const std::size_t rows = row_count(solver);
  std::uint64_t count = 0;
  for (std::size_t c = 0; c < chosen; ++c) {
    desc.column_starts[c] = count;
    std::fill_n(solver.targets.begin(), rows, 0.0f);
    RowReader(solver).visit_column(chosen_control(desc, c),
                                   [&](std::size_t row, float derivative) { solver.targets[row] = derivative; });
    for (std::uint32_t row = 0; row < rows; ++row) {
      if (solver.targets[row] == 0) continue;
      if (desc.column_rows && count < desc.column_entries) {
        desc.column_rows[count] = row;
        desc.column_values[count] = solver.targets[row];
      }
      ++count;
    }
  }
  desc.column_starts[chosen] = count;
  if (desc.column_rows && count > desc.column_entries)
    fail(Status::limit, "fb_jacobian_desc: column_entries is %llu, and there are %llu",
         static_cast<unsigned long long>(desc.column_entries), static_cast<unsigned long long>(count));
}

std::size_t read_chosen(const fb_solver& solver, const fb_jacobian_desc& desc) {
  const std::size_t controls = solver.controls.size(), chosen = desc.chosen ? desc.chosen_count : controls;
  for (std::size_t c = 0; desc.chosen && c < chosen; ++c)
    if (desc.chosen[c] >= controls || (c > 0 && desc.chosen[c] <= desc.chosen[c - 1]))
      fail(Status::invalid_argument, "fb_jacobian_desc: chosen[%zu] is %u, of %zu controls, and they have to ascend", c,
           desc.chosen[c], controls);
  if (desc.derivatives && chosen > 0 && desc.derivative_floats / chosen < row_count(solver))
    fail(Status::invalid_argument, "fb_jacobian_desc: derivative_floats is %llu; %zu rows of %zu controls need more",
         static_cast<unsigned long long>(desc.derivative_floats), row_count(solver), chosen);
  if (desc.column_rows) {
    require(desc.column_values, "fb_jacobian_desc: column_values");
    require(desc.column_starts, "fb_jacobian_desc: column_starts");
  }
  return chosen;
}

// ---- Solving ----

// What takes targets to the space of the face.
struct TargetSpace {
  explicit TargetSpace(const float (&matrix)[frame_floats]) {
    for (std::size_t i = 0; i < frame_floats; ++i) {
      if (!std::isfinite(matrix[i])) fail(Status::not_finite, "fb_solve_desc: to_face[%zu] is not finite", i);
      to_face[i] = matrix[i];
    }
    double lengths[3] = {}, products = 0;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) {
        double sum = 0;
        for (std::size_t row = 0; row < 3; ++row) sum += to_face[4 * row + a] * to_face[4 * row + b];
        if (a == b) lengths[a] = sum;
        if (a != b) products = std::max(products, std::fabs(sum));
      }
    scale = std::sqrt(lengths[0]);
    const double little = 1e-3 * lengths[0];
    if (!(lengths[0] > 0) || std::fabs(lengths[1] - lengths[0]) > little ||
        std::fabs(lengths[2] - lengths[0]) > little || products > little)
      fail(Status::invalid_argument, "fb_solve_desc: to_face does not scale alike in all directions");
  }
  // from: three numbers, `step` apart.
  void apply(const float* from, std::size_t step, bool direction, float* to) const {
    for (std::size_t row = 0; row < 3; ++row) {
      const double* const r = to_face + 4 * row;
      to[row * step] =
          static_cast<float>(r[0] * from[0] + r[1] * from[step] + r[2] * from[2 * step] + (direction ? 0 : r[3]));
    }
  }
  double to_face[frame_floats], scale;
};

void read_weights(const float* given, std::size_t count, const char* what, float* to) {
  for (std::size_t i = 0; i < count; ++i) {
    to[i] = given ? given[i] : 1;
    if (!(to[i] >= 0) || !(to[i] <= 1e12f))
      fail(Status::invalid_argument, "fb_solve_desc: %s[%zu] is %g, and has to be from 0 to 1e12", what, i, to[i]);
  }
}

// Sets the weight of what has a NaN to 0; refuses what is infinite.
void read_numbers(const float* numbers, std::size_t count, const char* what, std::size_t index, float& weight) {
  for (std::size_t i = 0; i < count && weight > 0; ++i) {
    if (std::isnan(numbers[i])) weight = 0;
    if (std::isinf(numbers[i]))
      fail(Status::not_finite, "fb_solve_desc: the target of %s %zu is infinite", what, index);
  }
}

void refuse_far(const float* numbers, std::size_t count, double most, const char* what, std::size_t index) {
  for (std::size_t i = 0; i < count; ++i)
    if (std::fabs(numbers[i]) > most)
      fail(Status::invalid_argument, "fb_solve_desc: the target of %s %zu has %g, farther than %g", what, index,
           numbers[i], most);
}

SolveTargets read_targets(fb_solver& solver, const fb_solve_desc& desc) {
  const double most = 1e6 * solver.owner.model->diagonal;
  const TargetSpace space(desc.to_face);
  float *const weights = solver.weights.data(), *const of_pairs = weights + solver.points,
               *const of_frames = of_pairs + solver.pairs;
  read_weights(desc.point_weights, solver.points, "point_weights", weights);
  read_weights(desc.distance_weights, solver.pairs, "distance_weights", of_pairs);
  read_weights(desc.frame_weights, solver.frames, "frame_weights", of_frames);
  float* const frames = solver.targets.data() + 3 * solver.points;
  for (std::size_t p = 0; desc.points && p < solver.points; ++p) {
    read_numbers(desc.points + 3 * p, 3, "point", p, weights[p]);
    if (weights[p] == 0) continue;
    float* const to = solver.targets.data() + 3 * p;
    space.apply(desc.points + 3 * p, 1, desc.relative != 0, to);
    for (std::size_t a = 0; a < 3 && desc.relative; ++a) to[a] += solver.rest_points[3 * p + a];
    refuse_far(to, 3, most, "point", p);
  }
  for (std::size_t k = 0; desc.distances && k < solver.pairs; ++k) {
    read_numbers(desc.distances + k, 1, "distance", k, of_pairs[k]);
    if (of_pairs[k] > 0) refuse_far(desc.distances + k, 1, most, "distance", k);
  }
  for (std::size_t f = 0; desc.frames && f < solver.frames; ++f) {
    read_numbers(desc.frames + f * frame_floats, frame_floats, "frame", f, of_frames[f]);
    if (of_frames[f] == 0) continue;
    float* const to = frames + f * frame_floats;
    for (std::size_t c = 0; c < 4; ++c) {
      space.apply(desc.frames + f * frame_floats + c, 4, c < 3, to + c);
      for (std::size_t row = 0; row < 3 && c < 3; ++row) to[4 * row + c] /= static_cast<float>(space.scale);
    }
    refuse_far(to, frame_floats, most, "frame", f);
  }
  return {desc.points ? solver.targets.data() : nullptr,
          weights,
          desc.distances,
          of_pairs,
          desc.frames ? frames : nullptr,
          of_frames};
}

double noise_of(const fb_model& model, float given) {
  if (given > 0) return given;
  const auto metres = fb::metres_per(model.evaluator.schema().units);
  return metres ? 0.0005 / *metres : 1e-3 * model.diagonal;
}

SolvePreferences read_preferences(const fb_solver& solver, const fb_solve_desc& desc) {
  for (const auto& [number, name] : {std::pair(desc.noise, "noise"), std::pair(desc.nearness, "nearness"),
                                     std::pair(desc.sparsity, "sparsity"), std::pair(desc.smoothness, "smoothness"),
                                     std::pair(desc.symmetry, "symmetry"), std::pair(desc.tolerance, "tolerance")})
    if (!(number >= 0) || !(number <= 1e12f))
      fail(Status::invalid_argument, "fb_solve_desc: %s is %g, and has to be from 0 to 1e12", name, number);
  for (const auto& [controls, name] :
       {std::pair(desc.near_controls, "fb_solve_desc: near_controls"), std::pair(desc.before, "fb_solve_desc: before")})
    if (controls) refuse_nan(solver, controls, name);
  SolvePreferences preferences;
  preferences.noise = noise_of(*solver.owner.model, desc.noise);
  preferences.nearness = desc.nearness;
  preferences.sparsity = desc.sparsity;
  preferences.smoothness = desc.smoothness;
  preferences.symmetry = desc.symmetry;
  preferences.near = desc.near_controls;
  preferences.before = desc.before;
  preferences.movable = desc.movable;
  preferences.find_motion = desc.find_motion != 0;
  preferences.most_iterations = desc.max_iterations;
  preferences.tolerance = desc.tolerance;
  return preferences;
}

// A given motion, which has to be a rotation and a translation.
RigidMotion read_motion(const fb_solve_desc& desc) {
  if (!desc.motion) {
    if (desc.find_motion) require(desc.motion, "fb_solve_desc: motion");
    return {};
  }
  const float* const m = desc.motion;
  if (std::all_of(m, m + frame_floats, [](float number) { return number == 0; })) return {};
  for (std::size_t i = 0; i < frame_floats; ++i)
    if (!std::isfinite(m[i])) fail(Status::not_finite, "fb_solve_desc: motion[%zu] is not finite", i);
  const auto motion = RigidMotion::of_matrix(m);
  if (!motion) fail(Status::invalid_argument, "fb_solve_desc: motion is not a rotation and a translation");
  return *motion;
}

void write_differences(const fb_solver& solver, float* to, fb_solve_result& result) {
  double squares = 0, most = -1;
  for (std::size_t p = 0; p < solver.points; ++p) {
    const bool counts = solver.solver.residuals().counts(p);
    double square = 0;
    for (const float number : solver.solver.residuals().difference(p)) square += double(number) * number;
    if (to) to[p] = counts ? static_cast<float>(std::sqrt(square)) : NAN;
    if (!counts) continue;
    squares += square;
    ++result.point_count;
    if (square > most) result.worst_point = static_cast<std::uint32_t>(p);
    most = std::max(most, square);
  }
  if (result.point_count == 0) return;
  result.rms_difference = static_cast<float>(std::sqrt(squares / result.point_count));
  result.max_difference = static_cast<float>(std::sqrt(most));
}

void write_result(const fb_solve_result& found, fb_solve_result* result) {
  if (!result) return;
  const std::uint32_t size = result->struct_size;
  fb_solve_result full = found;
  full.struct_size = size;
  std::memcpy(result, &full, std::min<std::size_t>(size, sizeof full));
}

}  // namespace

extern "C" {

void fb_solver_desc_fill(fb_solver_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_solver_create(const fb_model* model, const fb_solver_desc* desc, fb_solver** solver) {
  return abi_guard([&] {
    require(model, "model");
    require(solver, "solver");
    fb_solver_desc known;
    fb_solver_desc_init(&known);
    if (desc) known = read_struct(*desc, fb_solver_desc_init, "fb_solver_desc");
    fb::runtime::with_float_mode([&] { *solver = new fb_solver(model, known); });
  });
}

void fb_solver_destroy(fb_solver* solver) {
  delete solver;
}

uint32_t fb_solver_point_count(const fb_solver* solver) {
  return solver ? static_cast<uint32_t>(solver->points) : 0;
}

uint32_t fb_solver_row_count(const fb_solver* solver) {
  return solver ? static_cast<uint32_t>(row_count(*solver)) : 0;
}

void fb_jacobian_desc_fill(fb_jacobian_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_jacobian(fb_solver* solver, const fb_jacobian_desc* desc) {
  return abi_guard([&] {
    require(solver, "solver");
    require(desc, "desc");
    const fb_jacobian_desc known = read_struct(*desc, fb_jacobian_desc_init, "fb_jacobian_desc");
    const SolverUse use(solver);
    require(known.controls, "fb_jacobian_desc: controls");
    refuse_nan(*solver, known.controls, "fb_jacobian_desc");
    const std::size_t chosen = read_chosen(*solver, known);
    fb::runtime::with_float_mode([&] { solver->solver.derivative().run(known.controls, known.downwards); });
    for (std::size_t row = 0; known.values && row < row_count(*solver); ++row)
      known.values[row] = RowReader(*solver).value(row);
    if (known.derivatives) write_dense(*solver, known, chosen);
    if (known.column_starts) write_columns(*solver, known, chosen);
  });
}

void fb_solve_desc_fill(fb_solve_desc* to, uint32_t struct_size) {
  fb_solve_desc defaults = {};
  defaults.max_iterations = 20;
  defaults.to_face[0] = defaults.to_face[5] = defaults.to_face[10] = 1;
  defaults.nearness = defaults.sparsity = 0.1f;
  defaults.tolerance = 1e-2f;
  fill_struct(to, struct_size, defaults);
}

void fb_solve_result_fill(fb_solve_result* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_solve(fb_solver* solver, const fb_solve_desc* desc, fb_solve_result* result) {
  return abi_guard([&] {
    require(solver, "solver");
    require(desc, "desc");
    const fb_solve_desc known = read_struct(*desc, fb_solve_desc_init, "fb_solve_desc");
    if (result) fb::capi::require_size(result->struct_size, "fb_solve_result");
    const SolverUse use(solver);
    require(known.controls, "fb_solve_desc: controls");
    refuse_nan(*solver, known.controls, "fb_solve_desc");
    const SolvePreferences preferences = read_preferences(*solver, known);
    RigidMotion motion = read_motion(known);
    fb_solve_result found = {};
    fb::runtime::with_float_mode([&] {
      const SolveTargets targets = read_targets(*solver, known);
      std::copy_n(known.controls, solver->controls.size(), solver->controls.begin());
      const SolveResult solved = solver->solver.solve(targets, preferences, solver->controls.data(), motion);
      found.iterations = solved.iterations;
      found.converged = solved.converged;
      found.objective = solved.objective;
      write_differences(*solver, known.point_differences, found);
      if (known.decided) solver->solver.find_decided(preferences, known.decided);
    });
    std::copy(solver->controls.begin(), solver->controls.end(), known.controls);
    if (known.motion) motion.write_matrix(known.motion);
    write_result(found, result);
  });
}

}  // extern "C"
