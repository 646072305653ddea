#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/face_map.h"
#include "model/packed_model.h"

namespace fb::bake {

// Assigns each vertex to one region of a model.
struct FaceParts {
  std::vector<std::string> names;     // of the model's regions
  std::vector<std::uint32_t> labels;  // by vertex: the region; names.size() where none moves it
  // By region, see describe; empty before.
  std::vector<std::string> titles = {};               // unlike each other; "" without vertices
  std::vector<std::vector<std::string>> movers = {};  // controls
};

// A vertex is assigned to the region that moves it most over these poses (poses x controls, rig values): the largest
// sum, over the region's columns, of mean squared coefficient times squared displacement.
FaceParts face_parts(const PackedModel& model, std::span<const float> poses);

// Gives each region a title of the control group that moves it and the place where it lies ("mouth, lower left"): among
// the regions of that group, or in the face if it is the only one. And the names of up to five controls that move it
// most. `map` and `schema` are the model's.
void describe(FaceParts& parts, const FaceMap& map, const RigSchema& schema);

}  // namespace fb::bake
