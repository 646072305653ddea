#pragma once

#include <cstdint>
#include <string>

#include "bake/export/onnx_graph.h"
#include "model/packed_model.h"

namespace fb::bake {

// What the layers of a region make of its inputs x [n, features], less what they give at rest. Adds the numbers of
// their matrices to `parameters`.
std::string add_layers(OnnxGraph& graph, const PackedRegion& region, const std::string& x, std::uint64_t& parameters);

}  // namespace fb::bake
