// The files of a bag while it is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "bake/bag/closed_folder.h"
#include "base/progress.h"

namespace fb::bake {

struct BaggedFile {
  std::string digest;  // SHA-512
  std::uint64_t bytes = 0;
};

// Writes files into the folder of a bag, and keeps what its manifests list. Paths are of the bag, with slashes.
class BagFiles {
 public:
  BagFiles(std::filesystem::path folder, Progress& progress) : folder_(std::move(folder)), progress_(progress) {}

  // Each fails with bad_data on a path that no bag may have, or that some system takes for that of a file which is
  // there already, naming `from`, where the bytes come from; and with io.
  void write(const std::string& path, std::span<const std::byte> bytes, const std::string& from);
  void write(const std::string& path, std::string_view text);
  void copy(const std::string& path, const std::filesystem::path& file);
  void copy(const std::string& path, const ClosedFolder& from, const std::string& inside);
  // A file that is in the folder by now.
  void adopt(const std::string& path);

  // By path.
  const std::map<std::string, BaggedFile>& all() const { return files_; }
  // Lines of a manifest: of the payload, or of all else.
  std::string manifest(bool payload) const;
  // Makes the names in all folders durable.
  void sync_folders() const;

 private:
  struct Claim {
    std::string path, from;
  };
  // read(take): hands over the bytes, piece by piece.
  template <class Read>
  void write_pieces(const std::string& path, const std::string& from, Read&& read);
  void claim(const std::string& path, const std::string& from);

  std::filesystem::path folder_;
  Progress& progress_;
  std::map<std::string, BaggedFile> files_;
  std::map<std::string, Claim> claims_;  // by folded path
};

}  // namespace fb::bake
