#include "bake/analysis/curve_jumps.h"

#include <algorithm>
#include <cmath>

namespace fb::bake {
namespace {

constexpr double steep = 4;          // times its neighbours: an interval to bisect
constexpr double nearest = 0x1p-50;  // positions that are not bisected further: a jump next to rest

// One side of rest, outwards.
struct Side {
  std::vector<double> positions{0};           // with their sign; rest comes first
  std::vector<const std::vector<float>*> at;  // displacements; null for rest

  Side(const CurveSamples& samples, bool up) : at{nullptr} {
    for (std::size_t k = 0; k < samples.positions.size(); ++k) {
      const std::size_t i = up ? k : samples.positions.size() - 1 - k;
      if ((samples.positions[i] > 0) != up) continue;
      positions.push_back(samples.positions[i]);
      at.push_back(&samples.displacements[i]);
    }
  }

  std::size_t size() const { return positions.size(); }
  double width(std::size_t k) const { return std::abs(positions[k + 1] - positions[k]); }
};

// Largest distance of a vertex of `to` from (1 - t) a + t b; null stands for no displacement.
double distance(const std::vector<float>& to, const std::vector<float>* a, const std::vector<float>* b, double t) {
  double worst = 0;
  for (std::size_t i = 0; i < to.size(); i += 3) {
    double squares = 0;
    for (std::size_t k = i; k < i + 3; ++k) {
      const double d = to[k] - (a ? (1 - t) * (*a)[k] : 0) - (b ? t * (*b)[k] : 0);
      squares += d * d;
    }
    worst = std::max(worst, squares);
  }
  return std::sqrt(worst);
}

bool adjacent(float a, float b) {
  return std::nextafter(a, b) == b;
}

// The jump from sample k to k + 1 of a side, if it is one.
bool jumps_after(const Control& control, const Side& side, std::size_t k, double least) {
  return touch(control, side.positions[k], side.positions[k + 1]) &&
         distance(*side.at[k + 1], side.at[k], nullptr, 0) > least;
}

void append_middles(const Control& control, const CurveSamples& samples, bool up, double least,
                    std::vector<double>& middles) {
  const Side side(samples, up);
  std::vector<std::size_t> intervals;  // those that are no jumps
  std::vector<double> changes;
  for (std::size_t k = 0; k + 1 < side.size(); ++k)
    if (!jumps_after(control, side, k, least)) {
      intervals.push_back(k);
      changes.push_back(distance(*side.at[k + 1], side.at[k], nullptr, 0));
    }
  const auto slope = [&](std::size_t i) { return changes[i] / side.width(intervals[i]); };
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const double before = i > 0 ? slope(i - 1) : 0, after = i + 1 < intervals.size() ? slope(i + 1) : 0;
    const double from = side.positions[intervals[i]], to = side.positions[intervals[i] + 1];
    if (changes[i] > least && slope(i) > steep * std::max(before, after) && !touch(control, from, to))
      middles.push_back((from + to) / 2);
  }
}

void append_knots(const CurveSamples& samples, bool up, double tolerance, std::vector<double>& knots) {
  const Side side(samples, up);
  const auto fits = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from + 1; i < to; ++i) {
      const double t = (side.positions[i] - side.positions[from]) / (side.positions[to] - side.positions[from]);
      if (distance(*side.at[i], side.at[from], side.at[to], t) > tolerance) return false;
    }
    return true;
  };
  for (std::size_t from = 0; from + 1 < side.size();) {
    std::size_t to = from + 1;
    while (to + 1 < side.size() && fits(from, to + 1)) ++to;
    knots.push_back(side.positions[to]);
    from = to;
  }
}

}  // namespace

bool touch(const Control& control, double inside, double outside) {
  const float a = inside == 0 ? control.rest : value_at(control, inside), b = value_at(control, outside);
  return adjacent(a, b) || adjacent(a - control.rest, b - control.rest) || std::abs(outside - inside) <= nearest;
}

Feature step(const Control& control, std::uint32_t index, double inside, double outside) {
  // Exact in a reader's floats: the scale is a power of two, and so large that the offset outside is 1 or more above
  // the threshold, which is the offset inside.
  const float before = (inside == 0 ? control.rest : value_at(control, inside)) - control.rest;
  float after = value_at(control, outside) - control.rest;
  if (after == before) after = std::nextafter(after, outside > 0 ? INFINITY : -INFINITY);
  const float scale = std::ldexp(after > before ? 1.0f : -1.0f, std::clamp(-std::ilogb(after - before), -100, 100));
  return {Feature::Kind::hat, index, scale, before * scale, 0};
}

bool is_step(const Feature& feature) {
  return feature.kind == Feature::Kind::hat && feature.fall == 0;
}

std::vector<Jump> find_jumps(const Control& control, const CurveSamples& samples, double least) {
  std::vector<Jump> jumps;
  for (const bool up : {false, true}) {
    const Side side(samples, up);
    for (std::size_t k = 0; k + 1 < side.size(); ++k) {
      if (!jumps_after(control, side, k, least)) continue;
      jumps.push_back({side.positions[k], side.positions[k + 1], *side.at[k + 1]});
      if (!side.at[k]) continue;
      for (std::size_t i = 0; i < side.at[k]->size(); ++i) jumps.back().offsets[i] -= (*side.at[k])[i];
    }
  }
  return jumps;
}

CurveSamples without_jumps(const CurveSamples& samples, std::span<const Jump> jumps) {
  CurveSamples rest{samples.control, {}, {}};
  for (std::size_t i = 0; i < samples.positions.size(); ++i) {
    const double position = samples.positions[i];
    if (std::any_of(jumps.begin(), jumps.end(), [&](const Jump& jump) { return jump.outside == position; })) continue;
    rest.positions.push_back(position);
    rest.displacements.push_back(samples.displacements[i]);
    for (const Jump& jump : jumps)
      if (jump.outside > 0 ? position > jump.outside : position < jump.outside)
        for (std::size_t k = 0; k < jump.offsets.size(); ++k) rest.displacements.back()[k] -= jump.offsets[k];
  }
  return rest;
}

std::vector<double> positions_to_bisect(const Control& control, const CurveSamples& samples, double least) {
  std::vector<double> middles;
  for (const bool up : {false, true}) append_middles(control, samples, up, least, middles);
  return middles;
}

std::vector<double> plateau_middles(const Control& control, std::span<const Jump> jumps) {
  std::vector<double> middles;
  for (const bool up : {true, false}) {
    if (!has_side(control, up)) continue;
    std::vector<double> bounds = {0};
    for (const Jump& jump : jumps)
      if ((jump.outside > 0) == up) bounds.push_back(jump.outside);
    if (bounds.size() == 1) continue;
    bounds.push_back(up ? 1 : -1);
    for (std::size_t i = 0; i + 1 < bounds.size(); ++i)
      if (std::abs(bounds[i + 1] - bounds[i]) > 1e-3) middles.push_back((bounds[i] + bounds[i + 1]) / 2);
  }
  return middles;
}

std::vector<double> polyline_knots(const CurveSamples& samples, double tolerance) {
  std::vector<double> knots;
  for (const bool up : {false, true}) append_knots(samples, up, tolerance, knots);
  std::sort(knots.begin(), knots.end());
  return knots;
}

}  // namespace fb::bake
