// The sample face in several meshes.
#pragma once

#include <cstdint>
#include <vector>

#include "render/mesh_view.h"
#include "solve/similarity.h"

namespace fb::test {

struct HeadMesh {
  std::vector<float> points;
  std::vector<std::uint32_t> sizes, corners;

  tool::MeshView view() const { return {.points = points, .polygon_sizes = sizes, .polygon_corners = corners}; }
};

// As the plugin has it, in centimetres, y up, looking along z.
const HeadMesh& sample_head();
// Of another topology: a vertex in the middle of each polygon of the sample's mesh, whose quads are cut in
// divisions x divisions before, and a polygon round each of its vertices that is not on a border.
HeadMesh dual_head(std::uint32_t divisions);

HeadMesh moved(const HeadMesh& mesh, const tool::Similarity& by);
// Each coordinate moved by normally distributed numbers of this deviation.
HeadMesh with_noise(HeadMesh mesh, float deviation);
// Without the polygons that have a vertex above this x: about a quarter of the head at 2.6.
HeadMesh cut_beyond(const HeadMesh& mesh, float x);

// The largest distance of a vertex to where both similarities after each other take it.
double largest_error(const HeadMesh& mesh, const tool::Similarity& moved_by, const tool::Similarity& found);

}  // namespace fb::test
