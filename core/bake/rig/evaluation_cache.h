#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "bake/rig/rig_identity.h"
#include "base/input_file.h"

namespace fb::bake {

// Evaluated poses of one rig in a file, found by their controls, so that no stage of a bake evaluates what another has,
// nor the same stage after an interruption. The file holds a header with the rig's identity, and records of one size:
// a hash of the record, its origin, controls, points. A record that is cut off or damaged is ignored, and so is a whole
// file whose header is. Private to one version of the program and one machine's byte order. Not thread-safe.
class EvaluationCache {
 public:
  // Reads the controls of all records of the file, if there is one; creates nothing. Fails with invalid_argument,
  // naming the difference, on a file with records of another rig, and as InputFile does with what is no regular file
  // or cannot be read.
  EvaluationCache(std::filesystem::path path, RigIdentity rig);

  // The rig whose evaluations a file has; nothing where there is no such file.
  static std::optional<RigIdentity> rig_of(const std::filesystem::path& path);

  // Whether the pose is in the file; then its points are read into `points`.
  bool find(std::span<const float> controls, std::span<float> points);
  // Where points come from: evaluated in this folder, or before, by a version of the rig that gave the same.
  enum class Origin : std::uint64_t { evaluated = 0, reused = 1 };
  // Appends a pose, creating file and folder first if need be. Fails with io, naming the system's reason, where it
  // cannot be written.
  void store(std::span<const float> controls, std::span<const float> points, Origin origin = Origin::evaluated);
  // Hands what was stored to the operating system. Fails as `store` does; what was not written is not found then.
  void flush();

  // About the seconds that it takes to bring a pose to the disk and to read it again: measured with a file beside this
  // one, which is removed, and with as many bytes as take long enough to tell. Fails as `store` does.
  double measure_record_seconds() const;

  // Records so far, those included that are damaged or stored twice.
  std::uint64_t record_count() const { return record_count_; }
  std::uint64_t record_bytes() const;
  // Of the file, with one record more.
  std::uint64_t bytes_with_another() const { return header_bytes_ + (record_count_ + 1) * record_bytes(); }
  // Reads a record; false if it is damaged or not flushed yet.
  bool read(std::uint64_t record, std::span<float> controls, std::span<float> points);
  // Hashes (hash64_of) of the controls of records of origin reused that were there when the file was opened.
  const std::vector<std::uint64_t>& reused_poses() const { return reused_poses_; }

 private:
  void open_for_reading();
  void open_for_writing();
  [[noreturn]] void fail_writing(const std::string& reason) const;
  std::uint64_t record_hash(Origin origin, std::span<const float> controls, std::span<const float> points) const;

  std::filesystem::path path_;
  RigIdentity rig_;
  std::size_t width_, size_;                                  // floats of a pose's controls and points
  std::unordered_map<std::uint64_t, std::uint64_t> records_;  // by hash of controls; the last of equal ones
  std::vector<std::uint64_t> reused_poses_;
  std::uint64_t header_bytes_ = 0, record_count_ = 0;
  std::optional<InputFile> reading_;
  std::ofstream writing_;
  std::vector<float> found_;  // controls of the record that was read last
};

}  // namespace fb::bake
