#pragma once

#include <cstdint>
#include <string>

#include "bake/export/onnx_graph.h"
#include "model/packed_model.h"

namespace fb::bake {

// Displacements [n, rows], in the order of rows, of coefficients [n, columns]: a matrix product for every row block, of
// the columns that it uses, rounded as the evaluator rounds them. Adds the numbers of its matrices to `parameters`.
std::string add_basis(OnnxGraph& graph, const PackedModel& model, const std::string& coefficients,
                      std::uint64_t& parameters);

// The points [n, coordinates] with the corrections of exact poses, one after the other, by their weights [n, exact
// poses].
std::string add_corrections(OnnxGraph& graph, const PackedModel& model, const std::string& points,
                            const std::string& weights, std::uint64_t& parameters);

}  // namespace fb::bake
