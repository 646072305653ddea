#include "archive/section_writer.h"
#include "base/checked.h"

namespace fb::archive {

ByteWriter write_uvs(const Mesh& mesh) {
  const std::size_t pairs = mesh.uvs.size() / 2;
  const bool by_vertex = pairs == mesh.vertex_count() && mesh.uv_corners == mesh.polygon_corners;
  ByteWriter out;
  out.number(checked_u32(pairs, "texture coordinates"));
  out.number(static_cast<std::uint32_t>(by_vertex ? UvCoding::by_vertex : UvCoding::steps));
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::vector<float> of_axis;
    for (std::size_t i = axis; i < mesh.uvs.size(); i += 2) of_axis.push_back(mesh.uvs[i]);
    out.planes(of_axis);
  }
  if (!by_vertex) out.planes(corner_steps(mesh.polygon_sizes, mesh.uv_corners));
  return out;
}

}  // namespace fb::archive
