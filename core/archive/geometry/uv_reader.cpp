#include <cmath>

#include "archive/section_reader.h"
#include "base/checked.h"

namespace fb::archive {

void read_uvs(ByteReader& in, std::uint32_t vertices, Mesh& mesh) {
  const auto pairs = in.number<std::uint32_t>("the number of texture coordinates");
  const auto coding = in.number<std::uint32_t>("the coding of texture coordinates");
  if (coding > static_cast<std::uint32_t>(UvCoding::by_vertex))
    fail(Status::unsupported, "%s finds texture coordinates in unknown coding %u", in.where().c_str(), coding);
  if (pairs == 0) in.damaged("there are no texture coordinates");
  const std::vector<float> u = in.float_planes(pairs, "texture coordinates");
  const std::vector<float> v = in.float_planes(pairs, "texture coordinates");
  in.budget().take(pairs, 2 * sizeof(float), "texture coordinates");
  for (std::uint32_t i = 0; i < pairs; ++i) {
    if (!std::isfinite(u[i]) || !std::isfinite(v[i])) in.damaged("a texture coordinate is not finite");
    mesh.uvs.push_back(u[i]);
    mesh.uvs.push_back(v[i]);
  }
  if (static_cast<UvCoding>(coding) == UvCoding::steps) {
    const std::uint32_t corners = checked_u32(mesh.polygon_corners.size(), "corners");
    mesh.uv_corners = read_corner_steps(in, mesh.polygon_sizes, corners, pairs,
                                        "a corner names a texture coordinate that does not exist");
    return;
  }
  if (pairs != vertices) in.damaged("texture coordinates are not one a vertex");
  in.end();
  in.budget().take(mesh.polygon_corners.size(), sizeof(std::uint32_t), "corners");
  mesh.uv_corners = mesh.polygon_corners;
}

}  // namespace fb::archive
