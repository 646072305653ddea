// What is found in a bag.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace fb::bake {

// About a file of a bag, or about the bag as a whole where `file` is empty.
struct BagNote {
  std::string file, reason;
};

struct CheckedArchive {
  std::string file;
  std::uint64_t bytes = 0;
  std::size_t poses = 0, vertices = 0;  // that evaluate as archived
};

struct BagReport {
  std::string version;                                    // of BagIt, such as "1.0"; empty: not known
  std::vector<std::string> algorithms;                    // whose checksums were compared
  std::uint64_t files = 0, bytes = 0;                     // of the payload
  std::vector<std::pair<std::string, std::string>> info;  // of bag-info.txt
  std::vector<CheckedArchive> archives;
  std::vector<BagNote> faults, warnings;
  std::uint64_t more_faults = 0;  // that are not listed

  bool valid() const { return faults.empty(); }
  void add_fault(const std::string& file, const std::string& reason) {
    constexpr std::size_t most = 10000;  // bags may come from anyone
    if (faults.size() < most)
      faults.push_back({file, reason});
    else
      ++more_faults;
  }
  void add_warning(const std::string& file, const std::string& reason) { warnings.push_back({file, reason}); }
};

}  // namespace fb::bake
