// How long work tells its caller how far it is, and learns that it should stop.
#pragma once

#include <cstdint>
#include <string_view>

namespace fb {

class Progress {
 public:
  virtual ~Progress() = default;
  // A stage of `total` steps begins ("sampling poses"); the previous one, if any, is complete.
  virtual void begin(std::string_view stage, std::uint64_t total) = 0;
  // `done` steps of the current stage are complete.
  virtual void update(std::uint64_t done) = 0;
  // True once the user asked to stop; work ends at the next point where nothing is lost. Callable from any thread.
  virtual bool cancelled() const = 0;
  // A sentence worth reading that is not an error: a control nobody moves, a clip skipped.
  virtual void note(std::string_view sentence) = 0;

  // update, then throws Error(interrupted) if cancelled.
  void step(std::uint64_t done);
};

// Says nothing and never stops.
Progress& silent_progress();

}  // namespace fb
