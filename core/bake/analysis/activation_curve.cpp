#include "bake/analysis/activation_curve.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bake/analysis/blendshape_parts.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t most_powers = 4;
constexpr double fine = 0.01;             // of the tolerance: straight pieces are held to this if it is cheap
constexpr std::size_t most_samples = 24;  // of a side, before bent_places asks for no more

// The samples of one side, or of both, without vertices that keep to a straight line: those that bend most come first,
// so that a wrong curve is found out at once.
class Bends {
 public:
  Bends(const CurveSamples& samples, std::span<const std::size_t> picked) {
    const std::size_t vertices = samples.displacements.at(picked[0]).size() / 3;
    std::vector<float> moved(vertices);
    for (const std::size_t i : picked)
      for (std::size_t v = 0; v < vertices; ++v)
        moved[v] = std::max(moved[v], norm(samples.displacements[i].data() + 3 * v));
    std::vector<std::uint32_t> order;
    for (std::uint32_t v = 0; v < vertices; ++v)
      if (moved[v] > 0) order.push_back(v);
    const std::vector<float>& end = samples.displacements[picked.back()];
    const double last = samples.places[picked.back()];
    std::vector<float> bend(vertices);
    for (const std::size_t i : picked) {
      const auto t = static_cast<float>(samples.places[i] / last);
      for (const std::uint32_t v : order) {
        const float* d = samples.displacements[i].data() + 3 * v;
        const float off[3] = {d[0] - t * end[3 * v], d[1] - t * end[3 * v + 1], d[2] - t * end[3 * v + 2]};
        bend[v] = std::max(bend[v], norm(off));
      }
    }
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return bend[a] > bend[b]; });
    for (const std::size_t i : picked) {
      places.push_back(samples.places[i]);
      std::vector<float>& row = rows.emplace_back();
      row.reserve(3 * order.size());
      for (const std::uint32_t v : order)
        row.insert(row.end(), samples.displacements[i].data() + 3 * v, samples.displacements[i].data() + 3 * v + 3);
    }
  }

  std::size_t vertices() const { return rows[0].size() / 3; }

  static float norm(const float* d) { return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]); }

  std::vector<double> places;
  std::vector<std::vector<float>> rows;
};

constexpr double hopeless = std::numeric_limits<double>::infinity();

// Largest distance of `row` from sum of weights x rows; hopeless as soon as it is over the limit.
double distance(const Bends& bends, const std::vector<float>& row, std::span<const float* const> from,
                std::span<const float> weights, double limit) {
  double worst = 0;
  constexpr std::size_t block = 64;
  for (std::size_t first = 0; first < bends.vertices(); first += block) {
    const std::size_t last = std::min(bends.vertices(), first + block);
    float off[3 * block];
    std::copy(row.data() + 3 * first, row.data() + 3 * last, off);
    for (std::size_t k = 0; k < from.size(); ++k)
      for (std::size_t i = 0; i < 3 * (last - first); ++i) off[i] -= weights[k] * from[k][3 * first + i];
    for (std::size_t v = 0; v < last - first; ++v) worst = std::max(worst, double(Bends::norm(off + 3 * v)));
    if (worst > limit) return hopeless;
  }
  return worst;
}

struct Pieces {
  std::vector<std::size_t> knots;  // indices into the places of a side; the end is last
  double error = hopeless;
};

// Fewest straight pieces from rest to the end that keep all samples within the limit: the shortest path through the
// places, of which closer ones win among equals.
Pieces straight_pieces(const Bends& bends, double limit) {
  const std::size_t count = bends.places.size();
  struct Reached {
    double cost = hopeless, error = hopeless;
    std::size_t from = 0;
  };
  std::vector<Reached> reached(count + 1);  // 0 is rest
  reached[0] = {0, 0, 0};
  const auto place = [&](std::size_t i) { return i == 0 ? 0.0 : bends.places[i - 1]; };
  for (std::size_t to = 1; to <= count; ++to)
    for (std::size_t from = 0; from < to; ++from) {
      if (reached[from].cost == hopeless) continue;
      double worst = 0;
      for (std::size_t i = from + 1; i < to && worst != hopeless; ++i) {
        const double t = (place(i) - place(from)) / (place(to) - place(from));
        const float* rows[2] = {bends.rows[to - 1].data(), from == 0 ? nullptr : bends.rows[from - 1].data()};
        const float weights[2] = {static_cast<float>(t), static_cast<float>(1 - t)};
        const std::size_t ends = from == 0 ? 1 : 2;
        worst = std::max(worst, distance(bends, bends.rows[i - 1], {rows, ends}, {weights, ends}, limit));
      }
      if (worst == hopeless) continue;
      const double cost = reached[from].cost + 1 + 1e-3 * worst / limit;
      if (cost < reached[to].cost) reached[to] = {cost, std::max(worst, reached[from].error), from};
    }
  Pieces pieces;
  pieces.error = reached[count].error;
  for (std::size_t i = count; i > 0; i = reached[i].from) pieces.knots.insert(pieces.knots.begin(), i - 1);
  return pieces;
}

// As above with the tolerance asked for, a hundredth of it where that is cheap, and more where max_knots are too few.
Pieces choose_pieces(const Bends& bends, const CurveLimits& limits) {
  double limit = limits.tolerance;
  Pieces pieces = straight_pieces(bends, limit);
  while (pieces.knots.size() > limits.max_knots) pieces = straight_pieces(bends, limit *= 1.5);
  if (limit == limits.tolerance) {
    const Pieces finer = straight_pieces(bends, fine * limit);
    if (finer.knots.size() <= std::min<std::size_t>(pieces.knots.size() + 2, limits.max_knots)) return finer;
  }
  return pieces;
}

struct Powers {
  Eigen::MatrixXd weights;  // powers x samples: shapes from displacements
  double error = hopeless;
};

// Least squares over the samples with u, u^2 ... u^powers, as good as exact at the ends.
Powers fit_powers(const Bends& bends, std::span<const double> arguments, std::uint32_t powers, double limit) {
  const Eigen::Index count = static_cast<Eigen::Index>(arguments.size());
  if (powers > arguments.size()) return {};
  Eigen::MatrixXd design(count, powers);
  Eigen::VectorXd trust = Eigen::VectorXd::Ones(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    double power = 1;
    for (std::uint32_t p = 0; p < powers; ++p) design(i, p) = power *= arguments[static_cast<std::size_t>(i)];
  }
  trust[count - 1] = 1e5;
  if (bends.places.front() < 0) trust[0] = 1e5;
  const Eigen::MatrixXd weighted = design.transpose() * trust.asDiagonal();
  Powers fit{(weighted * design).ldlt().solve(weighted), 0};
  const Eigen::MatrixXf mix = (design * fit.weights).cast<float>();
  std::vector<const float*> rows;
  for (const std::vector<float>& row : bends.rows) rows.push_back(row.data());
  std::vector<float> weights(rows.size());
  for (Eigen::Index i = 0; i < count && fit.error != hopeless; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) weights[static_cast<std::size_t>(k)] = mix(i, k);
    fit.error = std::max(fit.error, distance(bends, bends.rows[static_cast<std::size_t>(i)], rows, weights, limit));
  }
  return fit;
}

// The fewest powers, below `fewer_than`, that stay within the limit.
Powers choose_powers(const Bends& bends, std::span<const double> arguments, std::size_t fewer_than, double limit) {
  Powers fit;
  for (std::uint32_t powers = 1; powers <= most_powers && powers < fewer_than && fit.error == hopeless; ++powers)
    fit = fit_powers(bends, arguments, powers, limit);
  return fit;
}

class CurveFitter {
 public:
  CurveFitter(const Control& control, const CurveSamples& samples, const CurveLimits& limits)
      : control_(control), samples_(samples), limits_(limits) {}

  ControlCurve fit() {
    std::vector<std::size_t> all, sides[2];
    for (std::size_t i = 0; i < samples_.places.size(); ++i) {
      if (samples_.places[i] < 0)
        sides[0].insert(sides[0].begin(), i);
      else
        sides[1].push_back(i);
      all.push_back(i);
    }
    Pieces pieces[2];
    std::size_t shapes = 0;
    double limit = limits_.tolerance;
    for (int up = 0; up < 2; ++up) {
      if (sides[up].empty()) continue;
      const Bends bends(samples_, sides[up]);
      pieces[up] = choose_pieces(bends, limits_);
      if (pieces[up].knots.size() > 1 && pieces[up].error <= fine * limits_.tolerance) limit = fine * limits_.tolerance;
      shapes += pieces[up].knots.size();
    }
    if (!sides[0].empty() && !sides[1].empty()) {
      const Bends bends(samples_, all);
      std::vector<double> arguments;
      for (const double place : bends.places)
        arguments.push_back((double(value_at(control_, place)) - control_.rest) / control_.reach());
      const Powers powers = choose_powers(bends, arguments, shapes, limit);
      if (powers.error != hopeless) {
        add_powers(across(control_, samples_.control), all, powers);
        curve_.smooth = true;
        return std::move(curve_);
      }
    }
    for (const bool up : {true, false}) {
      if (sides[up].empty()) continue;
      const Bends bends(samples_, sides[up]);
      std::vector<double> arguments;
      for (const double place : bends.places) arguments.push_back(std::abs(place));
      const Powers powers =
          choose_powers(bends, arguments, pieces[up].knots.size(),
                        pieces[up].error <= fine * limits_.tolerance ? fine * limits_.tolerance : limits_.tolerance);
      if (powers.error != hopeless) {
        add_powers(side_ramp(control_, samples_.control, up), sides[up], powers);
        curve_.smooth = sides[!up].empty();
      } else {
        add_pieces(sides[up], pieces[up], up);
      }
    }
    return std::move(curve_);
  }

 private:
  void add_shape(std::uint32_t feature, const std::vector<float>& offsets) {
    SparseShape shape = make_sparse(feature, offsets, limits_.drop);
    if (!shape.vertices.empty()) curve_.part.shapes.push_back(std::move(shape));
  }

  void add_powers(const Feature& argument, std::span<const std::size_t> picked, const Powers& powers) {
    std::vector<Feature>& features = curve_.part.features;
    const std::uint32_t first = add_feature(features, argument);
    std::uint32_t power = first;
    for (Eigen::Index p = 0; p < powers.weights.rows(); ++p) {
      if (p > 0) power = add_feature(features, {Feature::Kind::product, 0, 1, 0, 0, first, power});
      std::vector<double> sum(samples_.displacements[0].size());
      for (std::size_t k = 0; k < picked.size(); ++k) {
        const double weight = powers.weights(p, static_cast<Eigen::Index>(k));
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * samples_.displacements[picked[k]][i];
      }
      add_shape(power, std::vector<float>(sum.begin(), sum.end()));
    }
    curve_.error = std::max(curve_.error, powers.error);
  }

  // The chord, then knot after knot, each time the one whose displacement is furthest from the pieces so far.
  void add_pieces(std::span<const std::size_t> picked, const Pieces& pieces, bool up) {
    std::vector<Feature>& features = curve_.part.features;
    struct Knot {
      double place;
      const std::vector<float>* displacement;
    };
    const std::vector<float> zero(samples_.displacements[0].size());
    std::vector<Knot> placed = {{0, &zero}}, open;
    for (const std::size_t k : pieces.knots)
      open.push_back({samples_.places[picked[k]], &samples_.displacements[picked[k]]});
    placed.push_back(open.back());
    open.pop_back();
    // The ramp is 1 at the end of the range, which recordings may not reach.
    std::vector<float> chord = *placed[1].displacement;
    for (float& offset : chord) offset = static_cast<float>(offset / std::abs(placed[1].place));
    add_shape(add_feature(features, side_ramp(control_, samples_.control, up)), chord);
    while (!open.empty()) {
      double furthest = -1;
      std::size_t chosen = 0, before = 0;
      std::vector<float> surplus;
      for (std::size_t k = 0; k < open.size(); ++k) {
        std::size_t left = 0;
        while (std::abs(placed[left + 1].place) < std::abs(open[k].place)) ++left;
        const Knot &a = placed[left], &b = placed[left + 1];
        const auto t = static_cast<float>((open[k].place - a.place) / (b.place - a.place));
        std::vector<float> off(zero.size());
        double largest = 0;
        for (std::size_t i = 0; i < off.size(); ++i)
          off[i] = (*open[k].displacement)[i] - (1 - t) * (*a.displacement)[i] - t * (*b.displacement)[i];
        for (std::size_t v = 0; v < off.size() / 3; ++v)
          largest = std::max(largest, double(Bends::norm(off.data() + 3 * v)));
        if (largest > furthest) {
          furthest = largest, chosen = k, before = left;
          surplus = std::move(off);
        }
      }
      const Knot knot = open[chosen];
      add_shape(add_feature(features, tent(control_, samples_.control, placed[before].place, knot.place,
                                           placed[before + 1].place)),
                surplus);
      curve_.knots.push_back(knot.place);
      placed.insert(placed.begin() + static_cast<std::ptrdiff_t>(before) + 1, knot);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(chosen));
    }
    curve_.error = std::max(curve_.error, pieces.error);
  }

  const Control& control_;
  const CurveSamples& samples_;
  const CurveLimits& limits_;
  ControlCurve curve_;
};

// The nearest fraction of a small denominator, if it is very near.
double rounded(double place) {
  for (const int parts : {2, 3, 4, 5, 6, 8, 10, 12, 16, 20}) {
    const double near = std::round(place * parts) / parts;
    if (std::abs(near - place) < 1e-3) return near;
  }
  return place;
}

}  // namespace

float value_at(const Control& control, double place) {
  const double end = place > 0 ? control.maximum : control.minimum;
  const auto value = static_cast<float>(control.rest + std::abs(place) * (end - control.rest));
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

std::vector<double> bent_places(const CurveSamples& samples, const CurveLimits& limits) {
  std::vector<double> wanted;
  const std::size_t size = samples.displacements.at(0).size();
  const std::vector<float> zero(size);
  for (const bool up : {true, false}) {
    std::vector<double> places = {0};  // from rest outwards, as distances
    std::vector<const float*> rows = {zero.data()};
    for (std::size_t k = 0; k < samples.places.size(); ++k) {
      const std::size_t i = up ? k : samples.places.size() - 1 - k;
      if ((samples.places[i] > 0) != up) continue;
      places.push_back(std::abs(samples.places[i]));
      rows.push_back(samples.displacements[i].data());
    }
    if (places.size() > most_samples) continue;
    std::vector<bool> bent(places.size());
    for (std::size_t k = 1; k + 1 < places.size(); ++k) {
      const auto t = static_cast<float>((places[k] - places[k - 1]) / (places[k + 1] - places[k - 1]));
      float worst = 0;
      for (std::size_t i = 0; i < size; i += 3) {
        float off[3];
        for (std::size_t axis = 0; axis < 3; ++axis)
          off[axis] = rows[k][i + axis] - (1 - t) * rows[k - 1][i + axis] - t * rows[k + 1][i + axis];
        worst = std::max(worst, off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
      }
      bent[k] = std::sqrt(double(worst)) > limits.tolerance / 4;
    }
    for (std::size_t k = 0; k + 1 < places.size(); ++k) {
      const double low = places[k], high = places[k + 1];
      if (!bent[k] && !bent[k + 1]) continue;
      double place = (low + high) / 2;
      if (k > 0 && k + 2 < places.size()) {
        // Lines through the two samples before and the two behind: they meet, over all vertices, at
        // low + <jump, turn> / <turn, turn>, jump what the right line is above the left one at `low`.
        double met = 0, turned = 0;
        for (std::size_t i = 0; i < size; ++i) {
          const double left = (double(rows[k][i]) - rows[k - 1][i]) / (low - places[k - 1]);
          const double right = (double(rows[k + 2][i]) - rows[k + 1][i]) / (places[k + 2] - high);
          const double jump = double(rows[k + 1][i]) - right * (high - low) - rows[k][i];
          met += jump * (left - right);
          turned += (left - right) * (left - right);
        }
        const double meeting = turned > 0 ? rounded(low + met / turned) : place;
        const double margin = 0.02 * (high - low);
        if (std::abs(meeting - low) < margin || std::abs(meeting - high) < margin) continue;  // a sample already
        if (meeting > low && meeting < high) place = meeting;
      }
      wanted.push_back(up ? place : -place);
    }
  }
  return wanted;
}

}  // namespace fb::bake
