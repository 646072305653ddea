// The data of a real rig, read in place: a folder of NumPy arrays beside a rig.json.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace rigs {

template <class T>
struct Array {
  std::vector<std::size_t> shape;
  std::vector<T> values;  // C order

  // Numbers in one step of the first axis.
  std::size_t stride() const { return shape[0] ? values.size() / shape[0] : 0; }
};

class RigFolder {
 public:
  // Folder `name` in the folder that the environment variable FB_SHARED_RIGS gives, else in the one the build was
  // configured with. Throws std::runtime_error saying where it looked when there is none.
  explicit RigFolder(const std::string& name);

  std::string text(const std::string& file) const;
  // A little-endian float32 or int32 array; throws by file unless its shape is `shape`, where 0 stands for any length.
  Array<float> floats(const std::string& file, const std::vector<std::size_t>& shape) const;
  Array<std::int32_t> integers(const std::string& file, const std::vector<std::size_t>& shape) const;

 private:
  std::filesystem::path path_;
};

}  // namespace rigs
