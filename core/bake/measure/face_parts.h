#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/packed_model.h"

namespace fb::bake {

// Assigns each vertex to one region of a model.
struct FaceParts {
  std::vector<std::string> names;     // of the model's regions
  std::vector<std::uint32_t> labels;  // by vertex: the region; names.size() where none moves it
};

// A vertex is assigned to the region that moves it most over these poses (poses x controls, rig values): the largest
// sum, over the region's columns, of mean squared coefficient times squared displacement.
FaceParts face_parts(const PackedModel& model, std::span<const float> poses);

}  // namespace fb::bake
