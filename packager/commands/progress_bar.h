#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "base/progress.h"

namespace fb::tool {

// Progress on standard error: a bar that is redrawn in place on a terminal, a plain line now and then elsewhere. Asks
// interrupt.h whether to stop. All members may be called from any thread.
class ProgressBar final : public Progress {
 public:
  ProgressBar();
  // Completes the stage unless an exception is on its way.
  ~ProgressBar() override;

  void begin(std::string_view stage, std::uint64_t total) override;
  void update(std::uint64_t done) override;
  bool cancelled() const override;
  void note(std::string_view sentence) override;

 private:
  using Clock = std::chrono::steady_clock;
  void draw(Clock::time_point now);
  void finish_stage();

  const bool terminal_;
  const int exceptions_;  // on their way when this was made
  std::mutex mutex_;
  std::string stage_;  // empty: none
  std::uint64_t total_ = 0, done_ = 0;
  std::uint64_t start_done_ = 0;  // done when the stage began to count: a resumed stage starts in the middle
  bool counting_ = false;
  Clock::time_point start_, next_draw_;
};

// "1:05:09", "2:07", "9 s".
std::string duration_text(double seconds);

}  // namespace fb::tool
