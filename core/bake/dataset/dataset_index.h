#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bake/dataset/rest_mesh.h"
#include "bake/rig/source.h"
#include "model/character.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// The contents of dataset.json. File names are relative to its folder.
struct DatasetIndex {
  struct Entry {
    std::string name;
    ClipKind kind = ClipKind::shot;
    Split split = Split::train;
    double fps = 30;
    // One name may also stand for numbered shards ("x.points.npy" for "x.000.points.npy", ...); several are shards.
    std::vector<std::string> controls;
    std::vector<std::string> points;         // empty: a plan
    // As points, where poses have channels or driven joints: their numbers, see carried_count().
    std::vector<std::string> channels = {};
  };

  // Written by `sample`, so that it can be continued where it was interrupted; readers of the dataset ignore it.
  struct Sampling {
    std::uint64_t request = 0;       // hash of rig and options
    std::uint64_t plan = 0;          // hash of rig and controls
    std::uint64_t shard_frames = 0;  // frames a shard of points
    std::uint64_t left_out = 0;      // poses that failed, in whose places the rest pose is
  };

  RigSchema schema;
  MeshArrays rest_arrays;
  std::string rest_mesh;                  // a mesh file in place of rest_arrays; empty: none
  std::vector<MeshPart> parts;            // of the rest mesh
  Character character;                    // without the bytes of images, and without the skin
  std::vector<std::string> image_files;   // of each image
  std::string skin_joints, skin_weights;  // files of the skin; empty: none
  std::vector<DrivenJoint> driven_joints;
  std::string driven_skin_joints, driven_skin_weights;  // files of what follows them
  std::size_t driven_number_count() const { return DrivenJoints{driven_joints, {}, {}}.number_count(); }
  std::vector<Entry> clips;
  std::optional<Sampling> sampling;
  // The folder is a plan: points that clips name and that are not there yet are to be evaluated by some program.
  bool plan = false;
};

inline constexpr const char* dataset_file = "dataset.json";

// The path of a file that dataset.json names: path_inside() of its folder. A dataset may come from anyone, and is whole
// when its folder is copied.
std::filesystem::path dataset_path(const std::filesystem::path& folder, const std::string& name);

// Reads folder/dataset.json. Fails naming file and field on another format or version and on every field that is
// missing, of the wrong type or out of its words. Fields it does not know are ignored.
DatasetIndex read_dataset_index(const std::filesystem::path& folder);
// The same, but what is wrong is added to `faults`, one sentence each, and left out of the result; whether the schema
// makes sense is not checked.
DatasetIndex read_dataset_index(const std::filesystem::path& folder, std::vector<std::string>& faults);
// Reads a file of the same format that need have neither a rest mesh nor clips, such as who plans poses writes by hand.
DatasetIndex read_dataset_schema(const std::filesystem::path& file);
void write_dataset_index(const std::filesystem::path& folder, const DatasetIndex& index);

// The files of a clip's array: `names` as they are, or the numbered shards that a single missing name stands for. Fails
// if both are there, if a shard between others is missing, and as dataset_path does.
std::vector<std::filesystem::path> shard_files(const std::filesystem::path& folder,
                                               const std::vector<std::string>& names);
// Whether shard_files has any: of several names, all of them; of one, the file or its first shard.
bool has_shards(const std::filesystem::path& folder, const std::vector<std::string>& names);
// "x.points.npy", 7 -> "x.007.points.npy".
std::string shard_name(const std::string& name, std::size_t number);

}  // namespace fb::bake
