// Linear blend skinning as FORMAT.md says, for tests: computed here, without the library.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "model/character.h"

namespace fb::test {

using Place = std::array<double, 16>;  // a 4 x 4 matrix, column after column

inline Place times(const Place& a, const Place& b) {
  Place c{};
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return c;
}

inline Place place_of(std::span<const float> rows) {
  Place place{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column) place[4 * column + row] = double(rows[4 * row + column]);
  place[15] = 1;
  return place;
}

// Where joints are; `locals`: those that are not as at rest in their parents, by name.
inline std::vector<Place> joint_places(const Character& character, const std::map<std::string, Place>& locals = {}) {
  std::vector<Place> places;
  for (const Joint& joint : character.joints) {
    const auto found = locals.find(joint.name);
    const Place local = found == locals.end() ? place_of(joint.rest) : found->second;
    places.push_back(joint.parent == no_joint ? local : times(places.at(joint.parent), local));
  }
  return places;
}

// Points (3 x vertices, those of channels are left out) after skinning.
inline std::vector<double> skinned(const Character& character, const std::vector<Place>& places,
                                   std::span<const float> points) {
  const Skin& skin = character.skin;
  std::vector<double> all(points.begin(), points.end());
  for (std::size_t v = 0; skin.influences > 0 && v < points.size() / 3; ++v) {
    Place blend{};
    double sum = 0;
    for (std::size_t i = v * skin.influences; i < (v + 1) * skin.influences; ++i) {
      const Place moved = times(places.at(skin.joints[i]), place_of(character.joints.at(skin.joints[i]).inverse_bind));
      for (std::size_t k = 0; k < 16; ++k) blend[k] += double(skin.weights[i]) * moved[k];
      sum += double(skin.weights[i]);
    }
    for (std::size_t a = 0; sum > 0 && a < 3; ++a) {
      all[3 * v + a] = blend[12 + a];
      for (std::size_t k = 0; k < 3; ++k) all[3 * v + a] += blend[4 * k + a] * double(points[3 * v + k]);
    }
  }
  return all;
}

}  // namespace fb::test
