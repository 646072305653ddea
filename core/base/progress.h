// Progress reports and cancellation of long-running work.
#pragma once

#include <cstdint>
#include <string_view>

namespace fb {

// What a stage of work belongs to, in the order of a bake, which may come back to an earlier one.
enum class Phase {
  sampling,   // poses of a rig, and what tells which
  analysis,   // curves and correctives
  training,   // local blendshapes and networks
  packing,    // values are rounded and coded
  measuring,  // errors and times
  writing,    // reports, pictures, other forms of a face
};

class Progress {
 public:
  virtual ~Progress() = default;
  // A stage of `total` steps begins ("sampling poses"); the previous one, if any, is complete.
  virtual void begin(Phase phase, std::string_view stage, std::uint64_t total) = 0;
  // `done` steps of the current stage are complete.
  virtual void update(std::uint64_t done) = 0;
  // True once the user asked to stop; work ends at the next point where no result is lost. Callable from any thread.
  virtual bool cancelled() const = 0;
  // A message that is not an error, such as an unused control or a skipped clip.
  virtual void note(std::string_view sentence) = 0;

  // update(done), then throws Error(interrupted) if cancelled.
  void step(std::uint64_t done);
  // Between two steps: lets the user know that the work goes on, and throws Error(interrupted) if cancelled. Cheap
  // enough to be called a thousand times a second; to be called twice a second by whatever takes long. Callable from
  // any thread.
  virtual void ask();
};

// Ignores reports and never cancels.
Progress& silent_progress();

}  // namespace fb
