// Files for the tool to work on.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "model/packed_model.h"

// A fresh folder that is removed with everything in it.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }
  // Names in it, sorted.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

// The tiny model as a reader gets it, after writing its archive to `path`.
fb::PackedModel write_tiny_archive(const std::string& path);

// frames x controls random values within the ranges, written to `path` as a NumPy file too.
std::vector<float> write_clip(const std::string& path, const fb::RigSchema& schema, std::size_t frames);

// frames x 3 x vertices positions, by the runtime.
std::vector<float> evaluate_clip(const fb::PackedModel& model, const std::vector<float>& controls);
