#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>

namespace fb::bake {

// What a rig has answered, put by in the order it was asked, so that a probing that was interrupted asks it nothing
// twice: begun again, it asks the same. The file holds, answer after answer, a hash of all that was asked up to there,
// the points, and their hash; from the first answer on that is damaged, or one to something else, it is written anew.
class EvaluationCache {
 public:
  explicit EvaluationCache(std::filesystem::path path);

  // Whether the file answers what is asked next; then `points` is the answer.
  bool find(std::span<const float> controls, std::span<float> points);
  // Adds the answer to what was not found last. Fails with io where it cannot be written.
  void keep(std::span<const float> points);

 private:
  std::filesystem::path path_;
  std::ifstream known_;  // open while all that was asked was found
  std::ofstream more_;
  std::uint64_t asked_ = 0;        // hash of all that was asked
  std::uint64_t known_bytes_ = 0;  // of the answers found
};

}  // namespace fb::bake
