// A bone of the production rig, as its skin sees it.
#pragma once

#include <cstdint>
#include <vector>

#include "production/production_mesh.h"

namespace rigs::production {

constexpr std::uint32_t part_bit(Part part) {
  return 1u << static_cast<unsigned>(part);
}
constexpr std::uint32_t skin_parts = ~part_bit(Part::tongue);
constexpr std::uint32_t upper_parts = part_bit(Part::skin) | part_bit(Part::upper_lip),
                        lower_parts = part_bit(Part::skin) | part_bit(Part::lower_lip);

struct FaceBone {
  Vec head;             // in the rest pose
  float reach;          // radius of influence on the skin, cm
  std::uint32_t parts;  // part_bit of the vertices it may move
};

}  // namespace rigs::production
