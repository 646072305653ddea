// Progress for tests, which watches what work reports, or stops it.
#pragma once

#include <atomic>
#include <string>

#include "base/progress.h"

namespace fb::test {

// Ignores everything and never cancels; for those that override a part of it.
struct QuietProgress : Progress {
  void begin(fb::Phase, std::string_view, std::uint64_t) override {}
  void update(std::uint64_t) override {}
  bool cancelled() const override { return false; }
  void note(std::string_view) override {}
};

// Counts how often it is asked, and is cancelled from the question `stop_at` on.
struct Questions final : QuietProgress {
  bool cancelled() const override { return asked >= stop_at; }
  void ask() override {
    ++asked;
    Progress::ask();
  }
  std::atomic<int> asked{0}, stop_at{1 << 30};
};

// All notes, a line each.
struct Notes final : QuietProgress {
  void note(std::string_view sentence) override { all += std::string(sentence) + "\n"; }
  std::string all;
};

}  // namespace fb::test
