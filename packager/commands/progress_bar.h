#pragma once

#include <facebaker/facebaker_bake.h>

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "commands/bake_phases.h"

namespace fb::tool {

// Progress on standard error: on a terminal a bar that is redrawn in place, as wide as there is room for, else a line
// every 15 s. A stage that is over is told with the time it took, as one with those of its name right before it.
// Cancelled by the signals of interrupt.h. All members are thread-safe.
class ProgressBar final : public Progress {
 public:
  enum class Work { other, bake, bake_with_report };

  // Of a bake, each phase is told once (bake_phases.h), with the share of the whole that is done and an estimate of how
  // long the rest takes.
  explicit ProgressBar(Work work = Work::other);
  // Completes the stage, unless an exception unwinds the stack.
  ~ProgressBar() override;

  void begin(Phase phase, std::string_view stage, std::uint64_t total) override;
  void update(std::uint64_t done) override;
  bool cancelled() const override;
  void note(std::string_view sentence) override;

  // For calls of the C interface, which report to this bar; valid as long as it is.
  fb_callbacks callbacks();

 private:
  using Clock = std::chrono::steady_clock;
  bool begins(std::string_view stage, std::uint64_t done);
  void draw(Clock::time_point now);
  double share() const;
  std::string time_left(Clock::time_point now);
  void finish_stage();

  const bool terminal_, coloured_;
  const int exceptions_;  // in flight at construction
  std::mutex mutex_;
  std::optional<BakePhases> phases_;  // of a bake
  std::string stage_;                 // that is told: a stage, or a phase; empty: none
  std::string part_;                  // the stage that goes on
  std::uint64_t total_ = 0, done_ = 0;
  std::uint64_t start_done_ = 0;                 // at the first update: a resumed stage starts in the middle
  bool counting_ = false;                        // after the first update
  Clock::time_point begin_, start_, next_draw_;  // of the first stage, of this one
  Clock::time_point count_start_;                // of the first update
};

// Callbacks that append the notes of a call to a list, which must outlive them.
fb_callbacks collect_notes(std::vector<std::string>& notes);

// "1:05:09", "2:07", "9 s".
std::string duration_text(double seconds);

}  // namespace fb::tool
