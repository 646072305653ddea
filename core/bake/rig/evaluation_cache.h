#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "bake/rig/source.h"
#include "base/input_file.h"

namespace fb::bake {

// Evaluated poses of one rig in a file, found by their controls, so that no stage of a bake evaluates what another has,
// nor the same stage after an interruption. The file holds a header with a hash of the rig, and records of one size:
// a hash of the record, controls, points. A file of another rig is replaced; a record that is cut off or damaged is
// ignored. Private to one version of the program and one machine's byte order. Not thread-safe.
class EvaluationCache {
 public:
  // Reads the controls of all records of the file, if there is one; creates nothing. Fails as InputFile does with what
  // is no regular file or cannot be read.
  EvaluationCache(std::filesystem::path path, const Source& rig);

  // Whether the pose is in the file; then its points are read into `points`.
  bool find(std::span<const float> controls, std::span<float> points);
  // Appends a pose, creating file and folder first if need be. Fails with io where it cannot be written.
  void store(std::span<const float> controls, std::span<const float> points);
  // Hands what was stored to the operating system. Fails with io.
  void flush();

 private:
  void open_for_reading();
  void open_for_writing();
  [[noreturn]] void fail_writing() const;
  std::uint64_t record_hash(std::span<const float> controls, std::span<const float> points) const;
  std::uint64_t record_bytes() const;

  std::filesystem::path path_;
  std::uint64_t rig_hash_;
  std::size_t width_, size_;                                  // floats of a pose's controls and points
  std::unordered_map<std::uint64_t, std::uint64_t> records_;  // by hash of controls; the last of equal ones
  std::uint64_t record_count_ = 0;
  std::optional<InputFile> reading_;
  std::ofstream writing_;
  std::vector<float> found_;  // controls of the record that was read last
};

}  // namespace fb::bake
