// Point caches, as Blender, Maya, 3ds Max and Houdini write them: the positions of a mesh, frame by frame. Arrays of
// frames x points x 3; positions are taken as they are, whatever the axes. Times are not read: a frame of the file is a
// frame of its clip.
#pragma once

#include "bake/dataset/array_file.h"

namespace fb::bake {

// MDD, of LightWave. All big-endian: frames and points (int32), a time for each frame (float32), positions (float32).
class MddFile final : public ArrayFile {
 public:
  // Fails naming the file: missing, without frames or points, not as long as its header says.
  explicit MddFile(std::filesystem::path path);

 private:
  void read_rows(std::size_t first, std::span<float> values) const override;
};

// PC2, of 3ds Max. All little-endian: "POINTCACHE2\0", version (int32, 1), points (int32), first frame and frames a
// sample (float32), samples (int32), positions (float32).
class Pc2File final : public ArrayFile {
 public:
  // As MddFile, and on another version.
  explicit Pc2File(std::filesystem::path path);

 private:
  void read_rows(std::size_t first, std::span<float> values) const override;
};

}  // namespace fb::bake
