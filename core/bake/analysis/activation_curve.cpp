#include "bake/analysis/activation_curve.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "bake/analysis/blendshape_parts.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t most_powers = 4;
constexpr double fine = 0.01;             // of the tolerance: a polyline is held to it where that takes few knots
constexpr std::size_t most_samples = 24;  // of a side, which is not refined further then
// Within 1.5^120 (1e21) tolerances one segment fits all samples: points lie within 1e4 diagonals of their rest position
// (source_rules.h), and a tolerance is 1e-4 of the diagonal or more.
constexpr int most_coarsenings = 120;
constexpr double unreachable = std::numeric_limits<double>::infinity();

float norm(const float* d) {
  return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

// The picked samples at vertices that move. Vertices that bend most come first: they show a wrong curve at once.
struct SortedSamples {
  SortedSamples(const CurveSamples& samples, std::span<const std::size_t> picked) {
    const std::vector<std::uint32_t> order = most_bent_first(samples, picked);
    for (const std::size_t i : picked) {
      positions.push_back(samples.positions[i]);
      std::vector<float>& row = rows.emplace_back();
      row.reserve(3 * order.size());
      for (const std::uint32_t v : order)
        row.insert(row.end(), samples.displacements[i].data() + 3 * v, samples.displacements[i].data() + 3 * v + 3);
    }
  }

  std::size_t vertices() const { return rows[0].size() / 3; }

  std::vector<double> positions;
  std::vector<std::vector<float>> rows;  // displacements at each position

 private:
  // Vertices that move, by their largest distance from the chord to the last sample.
  static std::vector<std::uint32_t> most_bent_first(const CurveSamples& samples, std::span<const std::size_t> picked) {
    const std::size_t vertices = samples.displacements.at(picked[0]).size() / 3;
    std::vector<float> moved(vertices);
    for (const std::size_t i : picked)
      for (std::size_t v = 0; v < vertices; ++v)
        moved[v] = std::max(moved[v], norm(samples.displacements[i].data() + 3 * v));
    std::vector<std::uint32_t> order;
    for (std::uint32_t v = 0; v < vertices; ++v)
      if (moved[v] > 0) order.push_back(v);
    const std::vector<float>& end = samples.displacements[picked.back()];
    const double last = samples.positions[picked.back()];
    std::vector<float> bend(vertices);
    for (const std::size_t i : picked) {
      const auto t = static_cast<float>(samples.positions[i] / last);
      for (const std::uint32_t v : order) {
        const float* d = samples.displacements[i].data() + 3 * v;
        const float off[3] = {d[0] - t * end[3 * v], d[1] - t * end[3 * v + 1], d[2] - t * end[3 * v + 2]};
        bend[v] = std::max(bend[v], norm(off));
      }
    }
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return bend[a] > bend[b]; });
    return order;
  }
};

// Largest distance of `row` from the sum of weights x rows; unreachable as soon as it is over the limit.
double distance(const SortedSamples& samples, const std::vector<float>& row, std::span<const float* const> from,
                std::span<const float> weights, double limit) {
  double worst = 0;
  constexpr std::size_t block = 64;
  for (std::size_t first = 0; first < samples.vertices(); first += block) {
    const std::size_t last = std::min(samples.vertices(), first + block);
    float off[3 * block];
    std::copy(row.data() + 3 * first, row.data() + 3 * last, off);
    for (std::size_t k = 0; k < from.size(); ++k)
      for (std::size_t i = 0; i < 3 * (last - first); ++i) off[i] -= weights[k] * from[k][3 * first + i];
    for (std::size_t v = 0; v < last - first; ++v) worst = std::max(worst, double(norm(off + 3 * v)));
    if (worst > limit) return unreachable;
  }
  return worst;
}

struct Polyline {
  std::vector<std::size_t> knots;  // samples of a side, from rest outwards; the last is the end
  double error = unreachable;
};

// Fewest line segments from rest to the end that keep all samples within the limit: the shortest path through the
// samples, the smaller error winning among equal counts.
Polyline shortest_polyline(const SortedSamples& samples, double limit) {
  const std::size_t count = samples.positions.size();
  struct Reached {
    double cost = unreachable, error = unreachable;
    std::size_t from = 0;
  };
  std::vector<Reached> reached(count + 1);  // 0 is rest
  reached[0] = {0, 0, 0};
  const auto position = [&](std::size_t i) { return i == 0 ? 0.0 : samples.positions[i - 1]; };
  for (std::size_t to = 1; to <= count; ++to)
    for (std::size_t from = 0; from < to; ++from) {
      if (reached[from].cost == unreachable) continue;
      double worst = 0;
      for (std::size_t i = from + 1; i < to && worst != unreachable; ++i) {
        const double t = (position(i) - position(from)) / (position(to) - position(from));
        const float* rows[2] = {samples.rows[to - 1].data(), from == 0 ? nullptr : samples.rows[from - 1].data()};
        const float weights[2] = {static_cast<float>(t), static_cast<float>(1 - t)};
        const std::size_t ends = from == 0 ? 1 : 2;
        worst = std::max(worst, distance(samples, samples.rows[i - 1], {rows, ends}, {weights, ends}, limit));
      }
      if (worst == unreachable) continue;
      const double cost = reached[from].cost + 1 + 1e-3 * worst / limit;
      if (cost < reached[to].cost) reached[to] = {cost, std::max(worst, reached[from].error), from};
    }
  Polyline polyline;
  polyline.error = reached[count].error;
  for (std::size_t i = count; i > 0; i = reached[i].from) polyline.knots.insert(polyline.knots.begin(), i - 1);
  return polyline;
}

// Within the tolerance; finer where that takes few knots, coarser where max_knots are too few.
Polyline fit_polyline(const SortedSamples& samples, const CurveLimits& limits) {
  double limit = limits.tolerance;
  Polyline polyline = shortest_polyline(samples, limit);
  for (int i = 0; i < most_coarsenings && polyline.knots.size() > limits.max_knots; ++i)
    polyline = shortest_polyline(samples, limit *= 1.5);
  if (polyline.knots.size() > limits.max_knots)
    fail(Status::internal, "a curve through %zu samples does not fit within %g", samples.rows.size(), limit);
  if (limit == limits.tolerance) {
    const Polyline finer = shortest_polyline(samples, fine * limit);
    if (finer.knots.size() <= std::min<std::size_t>(polyline.knots.size() + 2, limits.max_knots)) return finer;
  }
  return polyline;
}

struct Polynomial {
  Eigen::MatrixXd weights;  // powers x samples: the shape of each power, as a sum of displacements
  double error = unreachable;
};

// Weighted least squares with u, u^2 ... u^powers: the ends of the range are all but interpolated.
Polynomial fit_powers(const SortedSamples& samples, std::span<const double> arguments, std::uint32_t powers,
                      double limit) {
  const Eigen::Index count = static_cast<Eigen::Index>(arguments.size());
  if (powers > arguments.size()) return {};
  Eigen::MatrixXd design(count, powers);
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    double power = 1;
    for (std::uint32_t p = 0; p < powers; ++p) design(i, p) = power *= arguments[static_cast<std::size_t>(i)];
  }
  weight[count - 1] = 1e5;
  if (samples.positions.front() < 0) weight[0] = 1e5;
  const Eigen::MatrixXd weighted = design.transpose() * weight.asDiagonal();
  Polynomial fit{(weighted * design).ldlt().solve(weighted), 0};
  const Eigen::MatrixXf mix = (design * fit.weights).cast<float>();
  std::vector<const float*> rows;
  for (const std::vector<float>& row : samples.rows) rows.push_back(row.data());
  std::vector<float> weights(rows.size());
  for (Eigen::Index i = 0; i < count && fit.error != unreachable; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) weights[static_cast<std::size_t>(k)] = mix(i, k);
    fit.error = std::max(fit.error, distance(samples, samples.rows[static_cast<std::size_t>(i)], rows, weights, limit));
  }
  return fit;
}

// The polynomial of fewest powers, below `fewer_than`, that stays within the limit.
Polynomial fit_polynomial(const SortedSamples& samples, std::span<const double> arguments, std::size_t fewer_than,
                          double limit) {
  Polynomial fit;
  for (std::uint32_t powers = 1; powers <= most_powers && powers < fewer_than && fit.error == unreachable; ++powers)
    fit = fit_powers(samples, arguments, powers, limit);
  return fit;
}

class CurveFitter {
 public:
  CurveFitter(const Control& control, const CurveSamples& samples, const CurveLimits& limits)
      : control_(control), samples_(samples), limits_(limits) {
    for (std::size_t i = 0; i < samples_.positions.size(); ++i) {
      if (samples_.positions[i] < 0)
        sides_[0].insert(sides_[0].begin(), i);
      else
        sides_[1].push_back(i);
      all_.push_back(i);
    }
  }

  ControlCurve fit() {
    for (const bool up : {false, true})
      if (!sides_[up].empty()) polylines_[up] = fit_polyline(SortedSamples(samples_, sides_[up]), limits_);
    if (!sides_[0].empty() && !sides_[1].empty() && fit_both_sides()) return std::move(curve_);
    for (const bool up : {true, false})
      if (!sides_[up].empty()) fit_side(up);
    return std::move(curve_);
  }

 private:
  bool is_fine(const Polyline& polyline) const { return polyline.error <= fine * limits_.tolerance; }

  // One polynomial through rest, if it has fewer shapes than the two polylines.
  bool fit_both_sides() {
    double limit = limits_.tolerance;
    for (const Polyline& polyline : polylines_)
      if (polyline.knots.size() > 1 && is_fine(polyline)) limit = fine * limits_.tolerance;
    const SortedSamples samples(samples_, all_);
    std::vector<double> arguments;
    for (const double position : samples.positions)
      arguments.push_back((double(value_at(control_, position)) - control_.rest) / control_.reach());
    const Polynomial polynomial =
        fit_polynomial(samples, arguments, polylines_[0].knots.size() + polylines_[1].knots.size(), limit);
    if (polynomial.error == unreachable) return false;
    add_polynomial(across(control_, samples_.control), all_, polynomial);
    curve_.smooth = true;
    return true;
  }

  void fit_side(bool up) {
    const Polyline& polyline = polylines_[up];
    const SortedSamples samples(samples_, sides_[up]);
    std::vector<double> arguments;
    for (const double position : samples.positions) arguments.push_back(std::abs(position));
    const Polynomial polynomial = fit_polynomial(samples, arguments, polyline.knots.size(),
                                                 is_fine(polyline) ? fine * limits_.tolerance : limits_.tolerance);
    if (polynomial.error == unreachable) return add_polyline(sides_[up], polyline, up);
    add_polynomial(side_ramp(control_, samples_.control, up), sides_[up], polynomial);
    curve_.smooth = sides_[!up].empty();
  }

  void add_shape(std::uint32_t feature, const std::vector<float>& offsets) {
    SparseShape shape = make_sparse(feature, offsets, limits_.drop);
    if (!shape.vertices.empty()) curve_.part.shapes.push_back(std::move(shape));
  }

  void add_polynomial(const Feature& argument, std::span<const std::size_t> picked, const Polynomial& polynomial) {
    std::vector<Feature>& features = curve_.part.features;
    const std::uint32_t first = add_feature(features, argument);
    std::uint32_t power = first;
    for (Eigen::Index p = 0; p < polynomial.weights.rows(); ++p) {
      if (p > 0) power = add_feature(features, {Feature::Kind::product, 0, 1, 0, 0, first, power});
      std::vector<double> sum(samples_.displacements[0].size());
      for (std::size_t k = 0; k < picked.size(); ++k) {
        const double weight = polynomial.weights(p, static_cast<Eigen::Index>(k));
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * samples_.displacements[picked[k]][i];
      }
      add_shape(power, std::vector<float>(sum.begin(), sum.end()));
    }
    curve_.error = std::max(curve_.error, polynomial.error);
  }

  struct Knot {
    double position;
    const std::vector<float>* displacement;
  };

  // A knot against the line between its neighbours.
  struct Surplus {
    double largest = 0;  // distance at a vertex
    std::vector<float> offsets;
  };

  static Surplus surplus_of(const Knot& knot, const Knot& before, const Knot& after) {
    const auto t = static_cast<float>((knot.position - before.position) / (after.position - before.position));
    Surplus surplus{0, std::vector<float>(knot.displacement->size())};
    for (std::size_t i = 0; i < surplus.offsets.size(); ++i)
      surplus.offsets[i] = (*knot.displacement)[i] - (1 - t) * (*before.displacement)[i] - t * (*after.displacement)[i];
    for (std::size_t v = 0; v < surplus.offsets.size() / 3; ++v)
      surplus.largest = std::max(surplus.largest, double(norm(surplus.offsets.data() + 3 * v)));
    return surplus;
  }

  // The chord, then knot after knot, always the one furthest from the polyline so far.
  void add_polyline(std::span<const std::size_t> picked, const Polyline& polyline, bool up) {
    std::vector<Feature>& features = curve_.part.features;
    const std::vector<float> zero(samples_.displacements[0].size());
    std::vector<Knot> placed = {{0, &zero}}, open;
    for (const std::size_t k : polyline.knots)
      open.push_back({samples_.positions[picked[k]], &samples_.displacements[picked[k]]});
    placed.push_back(open.back());
    open.pop_back();
    // The ramp is 1 at the end of the range, which recorded samples may not reach.
    std::vector<float> chord = *placed[1].displacement;
    for (float& offset : chord) offset = static_cast<float>(offset / std::abs(placed[1].position));
    add_shape(add_feature(features, side_ramp(control_, samples_.control, up)), chord);
    while (!open.empty()) {
      Surplus furthest{-1, {}};
      std::size_t chosen = 0, before = 0;
      for (std::size_t k = 0; k < open.size(); ++k) {
        std::size_t left = 0;
        while (std::abs(placed[left + 1].position) < std::abs(open[k].position)) ++left;
        Surplus surplus = surplus_of(open[k], placed[left], placed[left + 1]);
        if (surplus.largest <= furthest.largest) continue;
        furthest = std::move(surplus);
        chosen = k, before = left;
      }
      const Knot knot = open[chosen];
      add_shape(add_feature(features, tent(control_, samples_.control, placed[before].position, knot.position,
                                           placed[before + 1].position)),
                furthest.offsets);
      curve_.knots.push_back(knot.position);
      placed.insert(placed.begin() + static_cast<std::ptrdiff_t>(before) + 1, knot);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(chosen));
    }
    curve_.error = std::max(curve_.error, polyline.error);
  }

  const Control& control_;
  const CurveSamples& samples_;
  const CurveLimits& limits_;
  std::vector<std::size_t> sides_[2], all_;  // samples below and above rest, from rest outwards
  Polyline polylines_[2];
  ControlCurve curve_;
};

// The nearest fraction of a small denominator, if it is very near.
double rounded(double position) {
  for (const int parts : {2, 3, 4, 5, 6, 8, 10, 12, 16, 20}) {
    const double near = std::round(position * parts) / parts;
    if (std::abs(near - position) < 1e-3) return near;
  }
  return position;
}

}  // namespace

float value_at(const Control& control, double position) {
  const double end = position > 0 ? control.maximum : control.minimum;
  const auto value = static_cast<float>(control.rest + std::abs(position) * (end - control.rest));
  return std::clamp(value, control.minimum, control.maximum);
}

bool has_side(const Control& control, bool up) {
  return up ? control.maximum > control.rest : control.minimum < control.rest;
}

Feature side_ramp(const Control& control, std::uint32_t index, bool up) {
  return {Feature::Kind::ramp, index,
          static_cast<float>(1.0 / (double(up ? control.maximum : control.minimum) - control.rest))};
}

Feature across(const Control& control, std::uint32_t index) {
  return {Feature::Kind::identity, index, 1 / control.reach()};
}

Feature tent(const Control& control, std::uint32_t index, double left, double knot, double right) {
  const double reach = double(knot > 0 ? control.maximum : control.minimum) - control.rest;
  const double rise = std::abs(knot - left), drop = std::abs(right - knot);
  return {Feature::Kind::hat, index, static_cast<float>(1 / (reach * rise)), static_cast<float>(std::abs(left) / rise),
          static_cast<float>(rise / drop)};
}

ControlCurve fit_curve(const Control& control, const CurveSamples& samples, const CurveLimits& limits) {
  return CurveFitter(control, samples, limits).fit();
}

namespace {

// The samples of one side, from rest (included) outwards.
struct SideSamples {
  std::vector<double> positions;  // distances from rest
  std::vector<const float*> rows;

  SideSamples(const CurveSamples& samples, bool up, const float* rest) : positions{0}, rows{rest} {
    for (std::size_t k = 0; k < samples.positions.size(); ++k) {
      const std::size_t i = up ? k : samples.positions.size() - 1 - k;
      if ((samples.positions[i] > 0) != up) continue;
      positions.push_back(std::abs(samples.positions[i]));
      rows.push_back(samples.displacements[i].data());
    }
  }

  // Largest distance of sample k from the line between its neighbours.
  double bend(std::size_t k, std::size_t size) const {
    const auto t = static_cast<float>((positions[k] - positions[k - 1]) / (positions[k + 1] - positions[k - 1]));
    float worst = 0;
    for (std::size_t i = 0; i < size; i += 3) {
      float off[3];
      for (std::size_t axis = 0; axis < 3; ++axis)
        off[axis] = rows[k][i + axis] - (1 - t) * rows[k - 1][i + axis] - t * rows[k + 1][i + axis];
      worst = std::max(worst, off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    }
    return std::sqrt(double(worst));
  }

  // Where the line through the samples k - 1 and k and that through k + 1 and k + 2 meet, over all vertices: at
  // low + <jump, turn> / <turn, turn>, where jump is the right line minus the left one at `low`. Nothing if the lines
  // are parallel.
  std::optional<double> intersection(std::size_t k, std::size_t size) const {
    const double low = positions[k], high = positions[k + 1];
    double met = 0, turned = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double left = (double(rows[k][i]) - rows[k - 1][i]) / (low - positions[k - 1]);
      const double right = (double(rows[k + 2][i]) - rows[k + 1][i]) / (positions[k + 2] - high);
      const double jump = double(rows[k + 1][i]) - right * (high - low) - rows[k][i];
      met += jump * (left - right);
      turned += (left - right) * (left - right);
    }
    if (turned > 0) return rounded(low + met / turned);
    return std::nullopt;
  }
};

}  // namespace

std::vector<double> positions_to_refine(const CurveSamples& samples, const CurveLimits& limits) {
  std::vector<double> refined;
  const std::size_t size = samples.displacements.at(0).size();
  const std::vector<float> zero(size);
  for (const bool up : {true, false}) {
    const SideSamples side(samples, up, zero.data());
    const std::vector<double>& positions = side.positions;
    if (positions.size() > most_samples) continue;
    std::vector<bool> bent(positions.size());
    for (std::size_t k = 1; k + 1 < positions.size(); ++k) bent[k] = side.bend(k, size) > limits.tolerance / 4;
    for (std::size_t k = 0; k + 1 < positions.size(); ++k) {
      const double low = positions[k], high = positions[k + 1];
      if (!bent[k] && !bent[k + 1]) continue;
      double position = (low + high) / 2;
      if (k > 0 && k + 2 < positions.size()) {
        const double meeting = side.intersection(k, size).value_or(position);
        const double margin = 0.02 * (high - low);
        if (std::abs(meeting - low) < margin || std::abs(meeting - high) < margin) continue;  // a sample already
        if (meeting > low && meeting < high) position = meeting;
      }
      refined.push_back(up ? position : -position);
    }
  }
  return refined;
}

}  // namespace fb::bake
