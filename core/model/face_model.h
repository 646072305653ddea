#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/basis.h"
#include "model/mesh.h"
#include "model/network.h"
#include "model/rig_schema.h"

namespace fb {

// A baked face in floats: positions = rest points + basis * network(controls).
struct FaceModel {
  RigSchema schema;
  Mesh rest;
  Network network;
  Basis basis;             // rows = 3 x vertices, columns = network.coefficient_count()
  std::string provenance;  // a JSON object: recipe, creator, seed, sources, figures; for people and `inspect`
  std::vector<std::uint8_t> coarsest_levels = {};  // by vertex, for levels of detail: rows follow it, the highest
                                                   // first; empty: there are none
};

// Validates every part and their sizes against each other.
void check(const FaceModel& model);

}  // namespace fb
