#include "bake/check/rest_comparison.h"

#include <array>
#include <cmath>
#include <vector>

#include "base/length_units.h"
#include "base/status.h"
#include "base/surface.h"
#include "base/vector3.h"

namespace fb::bake {
namespace {

// Sizes of units against each other: millimetres, centimetres, decimetres, inches, feet, metres.
constexpr std::array factors = {10.0, 100.0, 1000.0, 2.54, 25.4, 39.3701, 3.28084, 30.48, 12.0};

Vector3 centre_of(std::span<const float> points) {
  double sum[3] = {};
  for (std::size_t i = 0; i < points.size(); ++i) sum[i % 3] += points[i];
  const double count = static_cast<double>(points.size() / 3);
  return {static_cast<float>(sum[0] / count), static_cast<float>(sum[1] / count), static_cast<float>(sum[2] / count)};
}

// Points with every vertex changed.
template <class Change>
std::vector<float> changed(std::span<const float> points, const Change& change) {
  std::vector<float> all;
  all.reserve(points.size());
  for (std::size_t v = 0; v < points.size() / 3; ++v) {
    const Vector3 moved = change(vector_at(points.data(), v));
    all.insert(all.end(), {moved.x, moved.y, moved.z});
  }
  return all;
}

// The factor between two sizes if it is one between units, else 1.
double unit_factor(double ratio) {
  for (const double factor : factors)
    for (const double either : {factor, 1 / factor})
      if (std::abs(ratio / either - 1) < 0.05) return either;
  return 1;
}

struct Turn {
  const char* text;
  Vector3 (*back)(Vector3);
};

constexpr Turn turns[] = {
    {"", [](Vector3 p) { return p; }},
    {"turned by a quarter around x, as if the other axis were up",
     [](Vector3 p) {
       return Vector3{p.x, p.z, -p.y};
     }},
    {"turned by a quarter around x, as if the other axis were up",
     [](Vector3 p) {
       return Vector3{p.x, -p.z, p.y};
     }},
    {"mirrored from left to right",
     [](Vector3 p) {
       return Vector3{-p.x, p.y, p.z};
     }},
    {"turned round by a half, to look the other way",
     [](Vector3 p) {
       return Vector3{-p.x, p.y, -p.z};
     }},
    {"turned round by a half, to look the other way",
     [](Vector3 p) {
       return Vector3{-p.x, -p.y, p.z};
     }},
};

std::string join(const std::vector<std::string>& texts) {
  std::string all;
  for (std::size_t i = 0; i < texts.size(); ++i)
    all += (i == 0 ? "" : i + 1 < texts.size() ? ", " : " and ") + texts[i];
  return all;
}

}  // namespace

RestDistance distance_from(std::span<const float> rest, std::span<const float> points, double diagonal) {
  RestDistance distance;
  const auto scale = static_cast<float>(1 / diagonal);
  for (std::size_t v = 0; v < rest.size() / 3; ++v) {
    const double apart = length((vector_at(points.data(), v) - vector_at(rest.data(), v)) * scale);
    if (apart > distance.largest) distance = {apart, v};
  }
  return distance;
}

std::string explain_distance(std::span<const float> rest, std::span<const float> points, double tolerance) {
  const double diagonal = box_diagonal(rest), ratio = box_diagonal(points) / diagonal;
  const double factor = unit_factor(ratio);
  const Vector3 home = centre_of(rest);
  for (const Turn& turn : turns) {
    const auto back = [&](Vector3 p) { return turn.back(p) * static_cast<float>(1 / factor); };
    const std::vector<float> there = changed(points, back);
    const Vector3 away = centre_of(there) - home;
    const bool moved = distance_from(rest, there, diagonal).largest > tolerance;
    const std::vector<float> placed = changed(there, [&](Vector3 p) { return p - away; });
    if (moved && distance_from(rest, placed, diagonal).largest > tolerance) continue;
    std::vector<std::string> causes;
    if (factor != 1) causes.push_back(format("%.4g times as large, as if in other units", factor));
    if (*turn.text) causes.emplace_back(turn.text);
    if (moved)
      causes.push_back(format("%.3g away, at %.3g %.3g %.3g of it, as if not in the mesh's own space",
                              double(length(away)), double(away.x), double(away.y), double(away.z)));
    return causes.empty() ? "" : "they are " + join(causes);
  }
  if (factor != 1) return format("they are about %.4g times as large, as if in other units", factor);
  if (std::abs(ratio - 1) < 1e-3 && double(length(centre_of(points) - home)) < 1e-3 * diagonal)
    return "they fill the same box, as if the vertices were in another order";
  return "";
}

std::optional<std::string> suspicious_size(double diagonal, const std::string& units) {
  constexpr double least = 0.02, most = 10;  // metres: a doll's face, a giant
  const std::optional<double> metres = metres_per(units);
  if (!metres || (diagonal * *metres >= least && diagonal * *metres <= most)) return std::nullopt;
  return format("the rest mesh is %.3g %s across, which is %.3g m: are its units another?", diagonal, units.c_str(),
                diagonal * *metres);
}

}  // namespace fb::bake
