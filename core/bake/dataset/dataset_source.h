#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bake/dataset/array_file.h"
#include "bake/dataset/dataset_index.h"
#include "bake/rig/source.h"

namespace fb::bake {

// One array in one or several files, consecutive along the first axis.
class ShardedArray {
 public:
  ShardedArray() = default;
  // Opens and checks every file. `row`: shape of one row; `need`: the shape needed, for messages.
  ShardedArray(const std::vector<std::filesystem::path>& files, const std::vector<std::size_t>& row, const char* need);

  std::size_t rows() const { return ends_.empty() ? 0 : ends_.back(); }
  // Reads rows [first, first + count), which must be there.
  void read(std::size_t first, std::size_t count, std::span<float> values) const;
  // The file a row is in.
  const std::filesystem::path& file_of(std::size_t row) const;

 private:
  std::size_t shard_of(std::size_t row) const;
  std::vector<std::unique_ptr<const ArrayFile>> shards_;
  std::vector<std::size_t> ends_;  // rows up to and with each shard
};

// A dataset folder as a source. Opening reads controls, rest mesh and the headers of all points; points are read from
// the disk when they are needed, so a dataset may be larger than memory.
class DatasetSource final : public Source {
 public:
  // Fails by file, field, frame, control on anything missing, truncated, mis-shaped, doubled or not finite, and
  // as check_source does. Of a plan, clips may have no points yet, or not those of all frames: these are not readable,
  // and a note says how many there are.
  explicit DatasetSource(const std::filesystem::path& folder);

  const RigSchema& schema() const override { return schema_; }
  const Mesh& rest() const override { return rest_; }
  const Character& character() const override { return character_; }
  const std::vector<Clip>& clips() const override { return clips_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool readable(std::size_t clip) const override { return points_.at(clip).rows() > 0; }
  std::vector<std::string> notes() const override { return notes_; }
  bool thread_safe() const override { return true; }

 private:
  ShardedArray open_shards(const std::vector<std::string>& names, const std::vector<std::size_t>& row, const char* what,
                           const Clip& clip, const DatasetIndex& index) const;
  void add_clip(const DatasetIndex::Entry& entry, const DatasetIndex& index);
  void note_range(const Clip& clip);
  void note_plan();

  std::filesystem::path folder_;
  RigSchema schema_;
  Mesh rest_;
  Character character_;
  double diagonal_ = 0;  // of the rest mesh
  std::vector<Clip> clips_;
  std::vector<ShardedArray> points_, channels_;  // of each clip
  std::vector<std::string> notes_;
};

}  // namespace fb::bake
