#include "bake/dataset/npy_skin.h"

#include <string>
#include <vector>

#include "bake/dataset/npy.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {

Skin read_npy_skin(const std::filesystem::path& joints, const std::filesystem::path& weights, std::size_t vertices) {
  const NpyFile of_joints(joints), of_weights(weights);
  for (const NpyFile* file : {&of_joints, &of_weights})
    if (file->shape().size() != 2 || file->rows() != vertices || file->row_size() == 0 ||
        file->row_size() > most_influences || file->shape() != of_joints.shape())
      fail(Status::bad_data, "%s: shape %s where (%zu, influences), 1 to %u, is needed", shown(file->path()).c_str(),
           file->shape_text().c_str(), vertices, most_influences);
  Skin skin{static_cast<std::uint32_t>(of_joints.row_size()), {}, {}};
  for (const std::int32_t joint : of_joints.read_integers()) {
    if (joint < 0 || std::size_t(joint) >= most_joints)
      fail(Status::bad_data, "%s: there is no joint %d", shown(joints).c_str(), joint);
    skin.joints.push_back(static_cast<std::uint16_t>(joint));
  }
  skin.weights.resize(skin.joints.size());
  of_weights.read(0, vertices, skin.weights);
  tidy(skin);
  return skin;
}

void write_npy_skin(const Skin& skin, const std::filesystem::path& joints, const std::filesystem::path& weights) {
  const std::vector<std::size_t> shape = {skin.weights.size() / skin.influences, skin.influences};
  write_npy(joints, shape, std::vector<std::int32_t>(skin.joints.begin(), skin.joints.end()));
  write_npy(weights, shape, skin.weights);
}

}  // namespace fb::bake
