#include "bake/dataset/dataset_character.h"

#include "bake/dataset/npy_skin.h"
#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint64_t most_image_bytes = std::uint64_t{1} << 30;

}  // namespace

Mesh read_rest_mesh(const std::filesystem::path& folder, const DatasetIndex& index) {
  const std::string& name = index.rest_mesh.empty() ? index.rest_arrays.points : index.rest_mesh;
  const std::filesystem::path path = dataset_path(folder, name);
  if (index.plan && !std::filesystem::exists(path))
    fail(Status::not_found, "%s: no such file: the program that evaluates this plan writes the rest mesh too",
         shown(path).c_str());
  Mesh mesh = index.rest_mesh.empty() ? read_npy_mesh(folder, index.rest_arrays) : read_mesh(path);
  mesh.parts = index.parts;
  if (!index.driven_joints.empty()) {
    mesh.driven.joints = index.driven_joints;
    mesh.driven.skin = read_npy_skin(dataset_path(folder, index.driven_skin_joints),
                                     dataset_path(folder, index.driven_skin_weights), mesh.vertex_count());
    round_weights(mesh.driven.skin);
  }
  return mesh;
}

Character read_dataset_character(const std::filesystem::path& folder, const DatasetIndex& index, const Mesh& rest) {
  Character character = index.character;
  for (std::size_t i = 0; i < character.images.size(); ++i)
    character.images[i].bytes = read_file(dataset_path(folder, index.image_files[i]), most_image_bytes);
  for (Socket& socket : character.sockets) set_default_frame(socket, rest.points);
  if (!index.skin_joints.empty())
    character.skin = read_npy_skin(dataset_path(folder, index.skin_joints), dataset_path(folder, index.skin_weights),
                                   rest.vertex_count());
  return character;
}

}  // namespace fb::bake
