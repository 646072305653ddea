#include "bake/dataset/schema_source.h"

#include "bake/dataset/dataset_character.h"
#include "bake/dataset/dataset_index.h"
#include "bake/rig/source_rules.h"
#include "base/shown_path.h"

namespace fb::bake {

SchemaSource::SchemaSource(const std::filesystem::path& file) {
  const DatasetIndex index = read_dataset_schema(file);
  const std::filesystem::path folder = file.parent_path().empty() ? "." : file.parent_path();
  schema_ = index.schema;
  if (!index.rest_mesh.empty() || !index.rest_arrays.points.empty()) {
    rest_ = read_rest_mesh(folder, index);
    character_ = read_dataset_character(folder, index, rest_);
    with_context(shown(file), [&] { check_source(schema_, rest_, character_); });
    return;
  }
  if (!index.skin_joints.empty() || !index.parts.empty() || !index.character.sockets.empty())
    fail(Status::bad_data, "%s: has meshes, sockets or a skin, but no \"rest\"", shown(file).c_str());
  character_ = read_dataset_character(folder, index, rest_);
}

void SchemaSource::read(std::size_t, std::size_t, std::size_t, std::span<float>) {
  fail(Status::invalid_argument, "\"%s\" is a schema: it has no clips", schema_.name.c_str());
}

}  // namespace fb::bake
