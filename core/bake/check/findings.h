#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/status.h"
#include "figures/dataset_figures.h"

namespace fb::bake {

// What is found in a dataset folder: faults, with which it cannot be baked, and warnings.
class Findings {
 public:
  void fault(std::string_view kind, std::string_view clip, std::string text) {
    faults_.push_back({std::string(kind), std::string(clip), std::move(text)});
  }
  void warn(std::string_view kind, std::string_view clip, std::string text) {
    warnings_.push_back({std::string(kind), std::string(clip), std::move(text)});
  }
  // Calls work(); what it throws about data is a fault. Returns whether it threw nothing.
  template <class Work>
  bool attempt(std::string_view kind, std::string_view clip, Work&& work) {
    try {
      work();
      return true;
    } catch (const Error& error) {
      if (error.status() == Status::interrupted) throw;
      fault(kind, clip, error.what());
      return false;
    }
  }
  const std::vector<Finding>& faults() const { return faults_; }
  const std::vector<Finding>& warnings() const { return warnings_; }

 private:
  std::vector<Finding> faults_, warnings_;
};

// Counts what a sentence is about and lists the first few: "12 frames: 3, 4, 9 and 9 more".
class Examples {
 public:
  void add(const std::string& one) {
    if (++count_ > most_listed) return;
    text_ += (text_.empty() ? "" : ", ") + one;
  }
  std::size_t count() const { return count_; }
  std::string text() const {
    return count_ > most_listed ? text_ + format(" and %zu more", count_ - most_listed) : text_;
  }

 private:
  static constexpr std::size_t most_listed = 5;
  std::size_t count_ = 0;
  std::string text_;
};

}  // namespace fb::bake
