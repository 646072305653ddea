// A face of a bag, as the documents beside it tell of it.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace fb::bake {

struct FaceRecord {
  std::string name;         // of the file, such as "old_king.fbk"
  std::string file;         // its path in the bag
  std::string character;    // as the archive calls it
  std::string version;      // of the format, "2.1"
  std::string creator;      // program and version that baked it; empty: not stated
  std::string created;      // date of the bake; empty: not stated
  std::string licence;      // text; empty: none
  std::string certificate;  // its main figures in words
  std::size_t poses = 0;    // of the proof, that evaluate as archived
  std::size_t vertices = 0;
  std::vector<std::pair<std::string, std::string>> about;  // "rights.expires" and its value, in the order of the text
  std::vector<std::pair<std::string, std::string>> provenance;  // likewise
  std::vector<std::string> copies;                              // access copies of it: paths in the bag

  // The value of a right, such as "expires"; empty: it has none.
  std::string right(const char* key) const;
};

// Reads the archive and evaluates its proof (verify_archive, which says how it fails). name: of the file.
FaceRecord read_face_record(std::span<const std::byte> archive, const std::string& name);

}  // namespace fb::bake
