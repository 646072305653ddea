#pragma once

#include <filesystem>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

// What poses can be planned for before there is a rig that answers: controls, and the rest mesh and character where
// they are known. Has no clips and evaluates nothing.
class SchemaSource final : public Source {
 public:
  // `file`: as dataset.json, but "rest" may be missing, and "clips" is not read. Fails naming the file and what is
  // wrong, as read_dataset_schema and check_source do.
  explicit SchemaSource(const std::filesystem::path& file);

  const RigSchema& schema() const override { return schema_; }
  const Mesh& rest() const override { return rest_; }  // without vertices where there is none
  const Character& character() const override { return character_; }
  const std::vector<Clip>& clips() const override { return clips_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;

 private:
  RigSchema schema_;
  Mesh rest_;
  Character character_;
  std::vector<Clip> clips_;
};

}  // namespace fb::bake
