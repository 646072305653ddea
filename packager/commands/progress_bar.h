#pragma once

#include <facebaker/facebaker_bake.h>

#include <chrono>
#include <mutex>
#include <string>
#include <vector>

#include "base/progress.h"

namespace fb::tool {

// Progress on standard error: on a terminal a bar that is redrawn in place, else a line every 15 s. Cancelled by the
// signals of interrupt.h. All members are thread-safe.
class ProgressBar final : public Progress {
 public:
  ProgressBar();
  // Completes the stage, unless an exception unwinds the stack.
  ~ProgressBar() override;

  void begin(std::string_view stage, std::uint64_t total) override;
  void update(std::uint64_t done) override;
  bool cancelled() const override;
  void note(std::string_view sentence) override;

  // For calls of the C interface, which report to this bar; valid as long as it is.
  fb_callbacks callbacks();

 private:
  using Clock = std::chrono::steady_clock;
  bool begins(std::string_view stage, std::uint64_t done);
  void draw(Clock::time_point now);
  void finish_stage();

  const bool terminal_;
  const int exceptions_;  // in flight at construction
  std::mutex mutex_;
  std::string stage_;  // empty: none
  std::uint64_t total_ = 0, done_ = 0;
  std::uint64_t start_done_ = 0;  // at the first update: a resumed stage starts in the middle
  bool counting_ = false;         // after the first update
  Clock::time_point start_, next_draw_;
};

// Callbacks that append the notes of a call to a list, which must outlive them.
fb_callbacks collect_notes(std::vector<std::string>& notes);

// "1:05:09", "2:07", "9 s".
std::string duration_text(double seconds);

}  // namespace fb::tool
