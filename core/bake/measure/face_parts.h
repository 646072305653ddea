#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/packed_model.h"

namespace fb::bake {

// Which network of a face a vertex belongs to.
struct FaceParts {
  std::vector<std::string> names;     // of the model's regions
  std::vector<std::uint32_t> labels;  // one a vertex; names.size() where no region moves it
};

// A vertex belongs to the region that moves it most over these poses (poses x controls, rig values): the one with the
// largest sum, over its columns, of mean squared coefficient times squared displacement.
FaceParts face_parts(const PackedModel& model, std::span<const float> poses);

}  // namespace fb::bake
