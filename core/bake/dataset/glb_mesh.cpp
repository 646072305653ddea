#include <tiny_gltf.h>

#include "bake/dataset/rest_mesh.h"
#include "bake/rig/gltf_file.h"
#include "base/file.h"
#include "base/status.h"

namespace fb::bake {

Mesh read_glb(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, std::uint64_t{1} << 31);
  return with_context(path.string(), [&] {
    const GltfFile file(bytes);
    const auto& meshes = file.model().meshes;
    if (meshes.size() != 1)
      fail(Status::bad_data, "holds %zu meshes; a rest mesh is the only one in its file", meshes.size());
    return file.triangles(meshes[0]);
  });
}

}  // namespace fb::bake
