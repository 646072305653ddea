#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/measure/face_map.h"
#include "model/expected_errors.h"
#include "model/packed_model.h"

namespace fb::bake {

// Parts of a face that different controls move, for expected errors.
struct ErrorRegions {
  std::vector<std::string> names;         // see describe of FaceParts; unlike each other
  std::vector<std::size_t> sizes;         // vertices of each
  std::vector<std::uint32_t> of_vertex;   // source order
  std::vector<ExpectedErrors::Run> runs;  // the same in baked order
};

// Up to seven clusters of row blocks, by the directions of their motion under single controls, and one of row blocks
// that nothing moves. `map`: the model's.
ErrorRegions error_regions(const PackedModel& model, const FaceMap& map, std::uint64_t seed);

}  // namespace fb::bake
